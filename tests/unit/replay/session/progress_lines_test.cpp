// SPDX-License-Identifier: Apache-2.0
#include "replay/session/progress_lines.h"

#include <gtest/gtest.h>

namespace zc {
namespace {

using Lines = std::vector<std::string>;

TEST(ProgressLines, ALineEachTenSecondsWithRateAndTimeLeft) {
  ProgressLines lines;
  EXPECT_EQ(lines.update(0, 0, "cut"), Lines{});
  EXPECT_EQ(lines.update(9.9, 0.4, "cut"), Lines{});
  EXPECT_EQ(lines.update(10, 0.25, "cut"), Lines{"cut: 25 % of all, 150.0 %/min, about 30 s left"});
  EXPECT_EQ(lines.update(19.9, 0.3, "cut"), Lines{});
  EXPECT_EQ(lines.update(100, 0.5, "cut"), Lines{"cut: 50 % of all, 30.0 %/min, about 1 min 40 s left"});
  EXPECT_EQ(lines.update(7200, 0.5, "cut"), Lines{"cut: 50 % of all, 0.4 %/min, about 2 h 0 min left"});
}

TEST(ProgressLines, CountsHaveTheirRate) {
  ProgressLines lines;
  EXPECT_EQ(lines.update(20, 0.25, "replay", {50, 200, "frames"}),
            Lines{"replay: 50 of 200 frames, 2.5 frames/s, about 1 min 0 s left"});
}

TEST(ProgressLines, ALineWhenAStageEnds) {
  ProgressLines lines;
  EXPECT_EQ(lines.update(0, 0, "import"), Lines{});
  EXPECT_EQ(lines.update(1.5, 0, "cut"), Lines{"import: done in 1.5 s, 0 % of all"});
  EXPECT_EQ(lines.update(2, 0.5, "cut"), Lines{});
  EXPECT_EQ(lines.finish(4), Lines{"cut: done in 2.5 s, 100 % of all"});
  EXPECT_EQ(lines.finish(4), Lines{}) << "an end is said once";
}

TEST(ProgressLines, ShortWorkHasNone) {
  ProgressLines lines(10);
  EXPECT_EQ(lines.update(0, 0, "import"), Lines{});
  EXPECT_EQ(lines.update(3, 0.2, "cut"), Lines{});
  EXPECT_EQ(lines.update(9.9, 0.9, "light"), Lines{});
  EXPECT_EQ(lines.finish(9.95), Lines{});
  ProgressLines longer(10);
  EXPECT_EQ(longer.update(0, 0, "import"), Lines{});
  EXPECT_EQ(longer.update(10, 0, "import"), Lines{"import: 0 % of all, 0.0 %/min"});
}

}  // namespace
}  // namespace zc
