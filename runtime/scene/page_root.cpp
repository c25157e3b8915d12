// SPDX-License-Identifier: Apache-2.0
#include "runtime/scene/page_root.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "base/check.h"

namespace zc {

NodeBox node_bounds(const gpu::PageNode& node) { return bounds_of_slots(node, inner_mask(node) | leaf_mask(node)); }

PageRoot page_root(std::span<const std::uint32_t> page) {
  ZC_CHECK(page.size() >= gpu::kPageHeaderWords + gpu::kPageNodeWords);
  gpu::PageHeader header;
  std::memcpy(&header, page.data(), sizeof header);
  PageRoot out;
  out.depth = header.depth;
  out.triangle_count = header.triangle_count;
  std::memcpy(&out.root, page.data() + gpu::kPageHeaderWords, sizeof out.root);
  out.child_count = static_cast<std::uint32_t>(std::popcount(inner_mask(out.root)));
  const std::size_t at = gpu::kPageHeaderWords + std::size_t{out.root.child_offset};
  ZC_CHECK(out.child_count == 0 || at + out.child_count * gpu::kPageNodeWords <= page.size());
  if (out.child_count > 0) std::memcpy(out.children.data(), page.data() + at, out.child_count * sizeof(gpu::PageNode));
  out.box = node_bounds(out.root);
  out.half_area = static_cast<float>(out.box.half_area());
  return out;
}

}  // namespace zc
