// SPDX-License-Identifier: Apache-2.0
#include "runtime/page_root.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "base/check.h"

namespace zc {
namespace {

// The slots in `used` as one box, within 32 bits: verify_page sees to it that they are.
NodeBox bounds(const gpu::PageNode& node, std::uint32_t used) {
  NodeBox all;
  for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
    if ((used >> slot & 1U) == 0) continue;
    const WideNodeBox box = child_box(node, slot);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      all.min[axis] = static_cast<std::int32_t>(std::min<std::int64_t>(all.min[axis], box.min[axis]));
      all.max[axis] = static_cast<std::int32_t>(std::max<std::int64_t>(all.max[axis], box.max[axis]));
    }
  }
  return all;
}

NodeBox bounds(const gpu::PageNode& node) { return bounds(node, inner_mask(node) | leaf_mask(node)); }

}  // namespace

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
  out.box = bounds(out.root);
  out.leaf_box = bounds(out.root, leaf_mask(out.root));
  out.half_area = static_cast<float>(out.box.half_area());
  for (std::size_t c = 0; c < out.child_count; ++c) out.child_boxes[c] = bounds(out.children[c]);
  return out;
}

}  // namespace zc
