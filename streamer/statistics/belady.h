// SPDX-License-Identifier: Apache-2.0
// How few reloads, and bytes read, any eviction could have managed: the nodes that a replay used, frame by frame, kept
// as changes, and Belady's rule (evict what is needed furthest in the future; Belady 1966) run over them with the whole
// future known. Pages differ in size, for which the rule is a strong reference rather than a proven optimum. Threads:
// one.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "streamer/statistics/paging_observer.h"
#include "streamer/statistics/statistics.h"
#include "streamer/world_format/index_view.h"

namespace zc {

// The pages that each frame used, as changes. One step: a count, then node << 1 | (1 when added).
class SelectionTrace final : public PagingObserver {
 public:
  explicit SelectionTrace(std::size_t most_words) : most_words_(most_words) {}

  // Sorted by id. A step that does not fit ends the record.
  void on_frame(std::span<const std::uint32_t> used) override;

  [[nodiscard]] bool complete() const { return complete_; }
  [[nodiscard]] std::span<const std::uint32_t> words() const { return words_; }

 private:
  std::size_t most_words_;
  bool complete_ = true;
  std::vector<std::uint32_t> words_;
  std::vector<std::uint32_t> before_;
};

// When every step's set must be resident in `budget_bytes`. Per node: bytes in the pool, and those that loading it
// reads.
[[nodiscard]] OptimalPaging belady(std::span<const std::uint32_t> trace, std::span<const std::uint64_t> node_bytes,
                                   std::span<const std::uint64_t> read_bytes, std::uint64_t budget_bytes);

// The same of a streamer's pages; nothing when the trace is not complete. Takes memory by what was used, not by the
// world's size.
[[nodiscard]] std::optional<OptimalPaging> optimal_paging(const SelectionTrace& trace, const IndexView& index,
                                                          std::uint64_t pool_bytes);

}  // namespace zc
