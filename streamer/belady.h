// SPDX-License-Identifier: Apache-2.0
// How few reloads, and bytes read, any eviction could have managed: the nodes that a replay used, frame by frame, kept
// as changes, and Belady's rule (evict what is needed furthest in the future; Belady 1966) run over them with the whole
// future known. Pages differ in size, for which the rule is a strong reference rather than a proven optimum. Threads:
// one.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "streamer/statistics.h"

namespace zc {

// Sets of nodes as changes in a buffer of fixed size. One step: a count, then node << 1 | (1 when added).
class SelectionTrace {
 public:
  explicit SelectionTrace(std::uint64_t capacity_words) : capacity_words_(capacity_words) {
    words_.reserve(capacity_words);
  }

  // Both sorted by id. A step that does not fit ends the record.
  void record(std::span<const std::uint32_t> before, std::span<const std::uint32_t> after);

  [[nodiscard]] bool complete() const { return complete_; }
  [[nodiscard]] std::span<const std::uint32_t> words() const { return words_; }

 private:
  std::uint64_t capacity_words_;
  bool complete_ = true;
  std::vector<std::uint32_t> words_;
};

// When every step's set must be resident in `budget_bytes`. Per node: bytes in the pool, and those that loading it
// reads.
[[nodiscard]] OptimalPaging belady(std::span<const std::uint32_t> trace, std::span<const std::uint64_t> node_bytes,
                                   std::span<const std::uint64_t> read_bytes, std::uint64_t budget_bytes);

// What belady() takes per node and per word of the trace.
inline constexpr std::uint64_t kBeladyBytesPerNode = 104;
inline constexpr std::uint64_t kBeladyBytesPerWord = 8;

}  // namespace zc
