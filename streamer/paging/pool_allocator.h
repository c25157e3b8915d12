// SPDX-License-Identifier: Apache-2.0
// First-fit offsets inside the fixed page pool: free ranges are coalesced, and everything is a multiple of
// kPageAlignWords. Threads: one · units: 32-bit words.
#pragma once

#include <cstdint>
#include <map>
#include <optional>

namespace zc {

class PoolAllocator {
 public:
  explicit PoolAllocator(std::uint64_t capacity_words);

  // Offset of the lowest hole that is large enough; nothing when there is none.
  [[nodiscard]] std::optional<std::uint64_t> allocate(std::uint64_t words);
  void free(std::uint64_t offset_words, std::uint64_t words);

  // Takes words that lie in one hole.
  void take(std::uint64_t offset_words, std::uint64_t words);

  [[nodiscard]] std::uint64_t capacity_words() const { return capacity_words_; }
  [[nodiscard]] std::uint64_t free_words() const { return free_words_; }

 private:
  std::uint64_t capacity_words_;
  std::uint64_t free_words_ = 0;
  std::map<std::uint64_t, std::uint64_t> holes_;  // offset -> words
};

// Words that a page of this size takes in the pool.
[[nodiscard]] std::uint64_t aligned_words(std::uint64_t words);

}  // namespace zc
