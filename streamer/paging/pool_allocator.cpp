// SPDX-License-Identifier: Apache-2.0
#include "streamer/paging/pool_allocator.h"

#include <iterator>

#include "base/check.h"
#include "streamer/paging/selection.h"

namespace zc {

std::uint64_t aligned_words(std::uint64_t words) {
  return (words + kPageAlignWords - 1) / kPageAlignWords * kPageAlignWords;
}

PoolAllocator::PoolAllocator(std::uint64_t capacity_words)
    : capacity_words_(capacity_words / kPageAlignWords * kPageAlignWords) {
  free_words_ = capacity_words_;
  if (free_words_ > 0) holes_.emplace(0, free_words_);
}

std::optional<std::uint64_t> PoolAllocator::allocate(std::uint64_t words) {
  words = aligned_words(words);
  ZC_CHECK(words > 0);
  for (auto hole = holes_.begin(); hole != holes_.end(); ++hole) {
    if (hole->second < words) continue;
    const std::uint64_t offset = hole->first;
    const std::uint64_t rest = hole->second - words;
    holes_.erase(hole);
    if (rest > 0) holes_.emplace(offset + words, rest);
    free_words_ -= words;
    return offset;
  }
  return std::nullopt;
}

void PoolAllocator::free(std::uint64_t offset_words, std::uint64_t words) {
  words = aligned_words(words);
  ZC_CHECK(words > 0 && offset_words + words <= capacity_words_);
  free_words_ += words;
  auto next = holes_.lower_bound(offset_words);
  ZC_CHECK(next == holes_.end() || offset_words + words <= next->first);
  if (next != holes_.end() && offset_words + words == next->first) {
    words += next->second;
    next = holes_.erase(next);
  }
  if (next != holes_.begin()) {
    const auto previous = std::prev(next);
    ZC_CHECK(previous->first + previous->second <= offset_words);
    if (previous->first + previous->second == offset_words) {
      previous->second += words;
      return;
    }
  }
  holes_.emplace_hint(next, offset_words, words);
}

void PoolAllocator::take(std::uint64_t offset_words, std::uint64_t words) {
  words = aligned_words(words);
  auto hole = holes_.upper_bound(offset_words);
  ZC_CHECK(words > 0 && hole != holes_.begin());
  --hole;
  const auto [begin, length] = *hole;
  ZC_CHECK(words <= length && offset_words - begin <= length - words);
  holes_.erase(hole);
  if (offset_words > begin) holes_.emplace(begin, offset_words - begin);
  const std::uint64_t rest = begin + length - offset_words - words;
  if (rest > 0) holes_.emplace(offset_words + words, rest);
  free_words_ -= words;
}

}  // namespace zc
