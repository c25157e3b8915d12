// SPDX-License-Identifier: Apache-2.0
#include "runtime/scene/page_root.h"

#include <bit>
#include <cstring>

#include "base/check.h"

namespace zc {

NodeBox node_bounds(const gpu::PageNode& node) { return bounds_of_slots(node, inner_mask(node) | leaf_mask(node)); }

gpu::PageNode load_node(const std::byte* at) {
  gpu::PageNode node;
  std::memcpy(&node, at, sizeof node);
  return node;
}

PageRoot page_root(std::span<const std::uint32_t> page) {
  ZC_CHECK(page.size() >= gpu::kPageHeaderWords + gpu::kPageNodeWords);
  gpu::PageHeader header;
  std::memcpy(&header, page.data(), sizeof header);
  const gpu::PageNode root = load_node(std::as_bytes(page).data() + 4 * gpu::kPageHeaderWords);
  PageRoot out;
  out.depth = header.depth;
  out.triangle_count = header.triangle_count;
  out.child_count = static_cast<std::uint32_t>(std::popcount(inner_mask(root)));
  out.child_words = gpu::kPageHeaderWords + root.child_offset;
  ZC_CHECK(out.child_count == 0 ||
           std::uint64_t{gpu::kPageHeaderWords} + root.child_offset + out.child_count * gpu::kPageNodeWords <=
               page.size());
  out.box = node_bounds(root);
  out.half_area = static_cast<float>(out.box.half_area());
  return out;
}

}  // namespace zc
