// SPDX-License-Identifier: Apache-2.0
// The resident pages: where each lies in the pool, and the cut that they show. Room is made by moving the fewest words
// that join holes into one large enough. Owns: the offsets; the words are the sink's. Borrows index and sink.
// Threads: one · units: 32-bit words, bytes.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/result.h"
#include "streamer/page_sink.h"
#include "streamer/paging/pool_allocator.h"
#include "streamer/paging/rendered_cut.h"
#include "streamer/paging/zeroed_array.h"

namespace zc {

class PagePool {
 public:
  // At most `pages` at once.
  PagePool(const IndexView& index, PageSink& sink, std::uint64_t pool_words, std::uint64_t pages);

  [[nodiscard]] bool has_room_for(std::uint32_t node) const;
  // There must be room. Fails only when the sink does.
  Status add(std::uint32_t node, std::span<const std::uint32_t> page);
  void remove(std::uint32_t node);

  [[nodiscard]] const RenderedCut& nodes() const { return nodes_; }
  [[nodiscard]] std::span<const std::uint32_t> residents() const { return residents_; }  // in no order
  [[nodiscard]] std::uint64_t offset_words(std::uint32_t node) const;
  [[nodiscard]] std::uint64_t page_bytes() const { return page_bytes_; }  // of the residents

  // Brings the cut up to date: sorted by id.
  void update_rendered_cut();
  [[nodiscard]] std::span<const std::uint32_t> rendered_cut() const { return cut_; }
  [[nodiscard]] std::uint64_t rendered_cut_generation() const { return generation_; }

  [[nodiscard]] std::uint64_t compactions() const { return compactions_; }
  [[nodiscard]] std::uint64_t compacted_bytes() const { return compacted_bytes_; }

 private:
  [[nodiscard]] std::uint64_t page_words(std::uint32_t node) const;
  Status compact(std::uint64_t words);

  const IndexView index_;
  PageSink& sink_;
  PoolAllocator pool_;
  RenderedCut nodes_;
  ZeroedArray<std::uint32_t> offsets_;  // of residents, in steps of kPageAlignWords
  std::vector<std::uint32_t> residents_;
  std::uint64_t page_bytes_ = 0;
  bool changed_ = false;
  std::vector<std::uint32_t> cut_;
  std::vector<std::uint32_t> previous_cut_;
  std::vector<std::uint64_t> cut_offsets_;
  std::uint64_t generation_ = 0;
  std::uint64_t compactions_ = 0;
  std::uint64_t compacted_bytes_ = 0;
};

}  // namespace zc
