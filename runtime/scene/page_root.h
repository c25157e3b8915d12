// SPDX-License-Identifier: Apache-2.0
// What the top level needs of a page, taken once, when the page is uploaded, so that a rebuild reads no page.
// The page is one that verify_page passed. Thread-safe: no state.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "shaders/shared/page_node.h"

namespace zc {

struct PageRoot {
  gpu::PageNode root{};
  std::array<gpu::PageNode, gpu::kNodeWidth> children{};
  std::uint32_t child_count = 0;
  std::uint32_t depth = 1;  // nodes on the page's longest path
  std::uint32_t triangle_count = 0;
  float half_area = 0;  // of `box`
  NodeBox box;          // of all that is in the root
};

// Of all that is in a node.
NodeBox node_bounds(const gpu::PageNode& node);

PageRoot page_root(std::span<const std::uint32_t> page);

}  // namespace zc
