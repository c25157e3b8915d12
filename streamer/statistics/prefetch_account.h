// SPDX-License-Identifier: Apache-2.0
// Whether what was loaded ahead of its time was ever asked for. Threads: one · units: compressed bytes.
#pragma once

#include <cstdint>
#include <vector>

#include "streamer/paging/selection.h"
#include "streamer/statistics/statistics.h"

namespace zc {

class PrefetchAccount {
 public:
  // At most `pages` are pending at once. Borrows the index.
  PrefetchAccount(const IndexView& index, std::uint64_t pages) : index_(index) { pending_.reserve(pages); }

  // Whether a camera asks for the node's level: its parent's error is too large for one of the current views.
  [[nodiscard]] bool asked_for(std::uint32_t node, const ErrorMeter& now, double tolerance) const;

  void loaded(std::uint32_t node);
  void evicted(std::uint32_t node);
  // Once a frame: what is asked for by now was well loaded.
  void settle(const ErrorMeter& now, double tolerance);

  [[nodiscard]] PrefetchBytes bytes() const { return {used_bytes_, wasted_bytes_, pending_bytes_}; }

 private:
  const IndexView index_;
  std::vector<std::uint32_t> pending_;
  std::uint64_t used_bytes_ = 0;
  std::uint64_t wasted_bytes_ = 0;
  std::uint64_t pending_bytes_ = 0;
};

}  // namespace zc
