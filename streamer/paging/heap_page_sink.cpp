// SPDX-License-Identifier: Apache-2.0
#include "streamer/paging/heap_page_sink.h"

#include <cstring>

#include "base/check.h"

namespace zc {

Status HeapPageSink::create(std::uint64_t capacity_words, std::uint64_t /*max_pages*/) {
  words_.assign(capacity_words, 0);  // assign writes every word
  return {};
}

Status HeapPageSink::upload(std::uint64_t offset_words, std::span<const std::uint32_t> page) {
  ZC_CHECK(offset_words <= words_.size() && page.size() <= words_.size() - offset_words);
  std::memcpy(words_.data() + offset_words, page.data(), page.size_bytes());
  return {};
}

Status HeapPageSink::move(std::uint64_t from_words, std::uint64_t to_words, std::uint64_t count_words) {
  ZC_CHECK(from_words <= words_.size() && count_words <= words_.size() - from_words);
  ZC_CHECK(to_words <= words_.size() && count_words <= words_.size() - to_words);
  std::memmove(words_.data() + to_words, words_.data() + from_words, count_words * sizeof(std::uint32_t));
  return {};
}

}  // namespace zc
