// SPDX-License-Identifier: Apache-2.0
#include "streamer/paging/rendered_cut.h"

#include <algorithm>

#include "base/check.h"

namespace zc {

RenderedCut::RenderedCut(const IndexView& index)
    : index_(index), resident_(index.nodes.size()), counts_(index.nodes.size()) {}

void RenderedCut::add(std::uint32_t node) {
  ZC_CHECK(!resident(node));
  const bool before = covered(node);
  resident_[node] = 1;
  if (!before) change_covered(node, true);
}

void RenderedCut::remove(std::uint32_t node) {
  ZC_CHECK(resident(node));
  resident_[node] = 0;
  if (!covered(node)) change_covered(node, false);
}

bool RenderedCut::refinable(std::uint32_t node) const {
  const std::uint32_t children = index_.nodes[node].child_count;
  return children > 0 && counts_[node] == children;
}

// `node` has become covered, or no longer is: so may its ancestors.
void RenderedCut::change_covered(std::uint32_t node, bool to) {
  while (node > 0) {
    const auto parent = static_cast<std::uint32_t>(index_.nodes[node].parent);
    const bool before = covered(parent);
    counts_[parent] += to ? 1U : ~0U;
    if (covered(parent) == before) return;
    node = parent;
  }
}

void RenderedCut::collect(std::vector<std::uint32_t>& cut) const {
  ZC_CHECK(resident(0));
  cut.clear();
  visit(0, cut);
  std::sort(cut.begin(), cut.end());
}

void RenderedCut::visit(std::uint32_t node, std::vector<std::uint32_t>& cut) const {  // as deep as the tree
  if (!refinable(node)) {
    cut.push_back(node);
    return;
  }
  const NodeRecord record = index_.nodes[node];
  for (std::uint32_t c = record.first_child; c < record.first_child + record.child_count; ++c) visit(c, cut);
}

}  // namespace zc
