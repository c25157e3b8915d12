// SPDX-License-Identifier: Apache-2.0
// The rendered cut as a page sink is shown it: in the order of offsets, with a mark on proxies that stand in for finer
// ones. Threads: one.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "streamer/page_sink.h"
#include "streamer/paging/page_pool.h"
#include "streamer/paging/selection.h"

namespace zc {

class ShownPages {
 public:
  // At most `most_pages` at once. Borrows index and pool.
  ShownPages(const IndexView& index, const PagePool& pool, double tolerance, std::uint64_t most_pages);

  // Whether anything differs from before. error_now: of the views that are now.
  bool update(const ErrorMeter& error_now);

  [[nodiscard]] std::span<const ShownPage> pages() const { return pages_; }

 private:
  [[nodiscard]] bool is_coarse(std::uint32_t node, const ErrorMeter& error_now) const;

  const IndexView index_;
  const PagePool& pool_;
  double tolerance_;
  std::vector<ShownPage> pages_;
  std::uint64_t generation_ = 0;  // of the rendered cut in pages_
};

}  // namespace zc
