// SPDX-License-Identifier: Apache-2.0
#include "streamer/paging/pool_allocator.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

#include "streamer/page_sink.h"
#include "streamer/paging/heap_page_sink.h"

namespace zc {
namespace {

TEST(PoolAllocator, joins_neighbouring_holes) {
  PoolAllocator pool(64);
  const auto a = pool.allocate(9);  // 16
  const auto b = pool.allocate(16);
  const auto c = pool.allocate(32);
  ASSERT_TRUE(a && b && c);
  EXPECT_EQ(pool.free_words(), 0U);
  EXPECT_FALSE(pool.allocate(1));
  pool.free(*a, 9);
  pool.free(*c, 32);
  EXPECT_FALSE(pool.allocate(40));
  pool.free(*b, 16);
  EXPECT_EQ(pool.allocate(64), 0U);
}

TEST(PoolAllocator, never_gives_a_word_twice) {
  PoolAllocator pool(4096);
  std::map<std::uint64_t, std::uint64_t> held;
  std::uint64_t held_words = 0;
  std::mt19937 random(3);
  for (int i = 0; i < 20000; ++i) {
    if (random() % 2 == 0) {
      const std::uint64_t words = 1 + random() % 300;
      const auto at = pool.allocate(words);
      if (!at) continue;
      EXPECT_EQ(*at % 8, 0U);
      EXPECT_LE(*at + aligned_words(words), 4096U);
      const auto after = held.lower_bound(*at);
      if (after != held.end()) {
        EXPECT_LE(*at + aligned_words(words), after->first);
      }
      if (after != held.begin()) {
        EXPECT_LE(std::prev(after)->first + aligned_words(std::prev(after)->second), *at);
      }
      held.emplace(*at, words);
      held_words += aligned_words(words);
    } else if (!held.empty()) {
      auto one = held.begin();
      std::advance(one, random() % held.size());
      pool.free(one->first, one->second);
      held_words -= aligned_words(one->second);
      held.erase(one);
    }
    ASSERT_EQ(pool.free_words(), 4096 - held_words);
  }
}

TEST(HeapPageSink, moves_overlapping_ranges_like_memmove) {
  HeapPageSink sink;
  ASSERT_TRUE(sink.create(16, 1).ok());
  const std::vector<std::uint32_t> page = {1, 2, 3, 4, 5, 6};
  ASSERT_TRUE(sink.upload(4, page).ok());
  ASSERT_TRUE(sink.move(4, 2, 6).ok());
  EXPECT_EQ(sink.words()[2], 1U);
  EXPECT_EQ(sink.words()[7], 6U);
}

}  // namespace
}  // namespace zc
