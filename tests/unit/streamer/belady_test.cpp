// SPDX-License-Identifier: Apache-2.0
#include "streamer/statistics/belady.h"

#include <gtest/gtest.h>

namespace zc {
namespace {

using Ids = std::vector<std::uint32_t>;

OptimalPaging optimum(const std::vector<Ids>& selections, const std::vector<std::uint64_t>& bytes,
                      std::uint64_t budget) {
  SelectionTrace trace(1000);
  for (const Ids& selection : selections) trace.on_frame(selection);
  EXPECT_TRUE(trace.complete());
  return belady(trace.words(), bytes, bytes, budget);
}

std::uint64_t reloads(const std::vector<Ids>& selections, const std::vector<std::uint64_t>& bytes,
                      std::uint64_t budget) {
  return optimum(selections, bytes, budget).reloads;
}

TEST(Belady, matches_a_trace_worked_by_hand) {
  // Root 0 and one more page fit beside the selected one. 1, 2 fill the pool; 3 comes: 2 is needed at the sixth step
  // and 1 at the fourth, so 2 goes. 1 stays free. 2 at the sixth step is the one reload (LRU would reload 1 as well).
  const std::vector<Ids> selections = {{0, 1}, {0, 2}, {0, 3}, {0, 1}, {0, 3}, {0, 2}};
  EXPECT_EQ(reloads(selections, {1, 1, 1, 1}, 3), 1U);
  EXPECT_EQ(reloads(selections, {1, 1, 1, 1}, 2), 3U);  // no cache at all: 1, 3 and 2 come again
  EXPECT_EQ(reloads(selections, {1, 1, 1, 1}, 4), 0U);
}

TEST(Belady, counts_bytes_rather_than_pages) {
  // 2 takes two units: keeping it beside 0 and 3 is not possible in 3, keeping 1 is.
  EXPECT_EQ(reloads({{0, 1}, {0, 3}, {0, 1}}, {1, 1, 2, 1}, 3), 0U);
  EXPECT_EQ(reloads({{0, 2}, {0, 3}, {0, 2}}, {1, 1, 2, 1}, 3), 1U);
}

TEST(Belady, reads_every_page_once_and_again_at_each_reload) {
  const std::vector<Ids> selections = {{0, 1}, {0, 2}, {0, 3}, {0, 1}, {0, 3}, {0, 2}};
  EXPECT_EQ(optimum(selections, {1, 1, 1, 1}, 3).bytes_read, 5U);
  EXPECT_EQ(optimum(selections, {1, 1, 1, 1}, 4).bytes_read, 4U);
}

TEST(SelectionTrace, frames_without_a_change_take_nothing_and_a_full_buffer_ends_it) {
  SelectionTrace trace(4);
  trace.on_frame(Ids{0});
  const std::size_t words = trace.words().size();
  for (int i = 0; i < 100; ++i) trace.on_frame(Ids{0});
  EXPECT_EQ(trace.words().size(), words);
  EXPECT_TRUE(trace.complete());
  trace.on_frame(Ids{0, 1, 2, 3});
  EXPECT_FALSE(trace.complete());
  EXPECT_EQ(trace.words().size(), words);
}

}  // namespace
}  // namespace zc
