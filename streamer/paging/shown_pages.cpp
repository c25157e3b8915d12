// SPDX-License-Identifier: Apache-2.0
#include "streamer/paging/shown_pages.h"

#include <algorithm>
#include <utility>

namespace zc {

ShownPages::ShownPages(const IndexView& index, const PagePool& pool, double tolerance, std::uint64_t most_pages)
    : index_(index), pool_(pool), tolerance_(tolerance) {
  pages_.reserve(most_pages);
}

// The finest proxies stand in for nothing: what is finer is the full detail, which is another set's.
bool ShownPages::is_coarse(std::uint32_t node, const ErrorMeter& error_now) const {
  const NodeRecord record = index_.nodes[node];
  if (record.child_count == 0 || index_.nodes[record.first_child].is_detail()) return false;
  return error_now(record).weighted > tolerance_;
}

bool ShownPages::update(const ErrorMeter& error_now) {
  const bool other_cut = generation_ != pool_.rendered_cut_generation();
  bool changed = other_cut;
  if (other_cut) {
    generation_ = pool_.rendered_cut_generation();
    pages_.clear();
    for (const std::uint32_t node : pool_.rendered_cut()) pages_.push_back({pool_.offset_words(node), node, false});
    std::ranges::sort(pages_, {}, &ShownPage::offset_words);
  }
  for (ShownPage& page : pages_) {
    const bool coarse = is_coarse(page.node, error_now);
    changed = std::exchange(page.coarse, coarse) != coarse || changed;
  }
  return changed;
}

}  // namespace zc
