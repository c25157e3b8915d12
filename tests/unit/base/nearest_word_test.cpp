// SPDX-License-Identifier: Apache-2.0
#include "base/nearest_word.h"

#include <gtest/gtest.h>

#include <array>

namespace zc {
namespace {

TEST(NearestWord, DistancesOfKnownPairs) {
  EXPECT_EQ(edit_distance("", ""), 0U);
  EXPECT_EQ(edit_distance("wall", "wal"), 1U);
  EXPECT_EQ(edit_distance("bkae", "bake"), 1U) << "neighbours that are swapped";
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
  EXPECT_EQ(edit_distance("ca", "abc"), 3U) << "each letter once";
}

TEST(NearestWord, TheNearestIsNamedAndNothingThatIsFar) {
  const std::array<std::string, 3> names = {"virtual", "wall", "none"};
  EXPECT_EQ(did_you_mean("virtaul", names), "; did you mean 'virtual'?");
  EXPECT_EQ(did_you_mean("wal", names), "; did you mean 'wall'?");
  EXPECT_EQ(did_you_mean("sundial", names), "");
  EXPECT_EQ(did_you_mean("", names), "") << "no name is as short as what it would replace";
  EXPECT_EQ(did_you_mean(std::string(1'000'000, 'w'), names), "");
}

}  // namespace
}  // namespace zc
