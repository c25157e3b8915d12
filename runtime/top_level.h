// SPDX-License-Identifier: Apache-2.0
// The top-level BVH over resident zones, rebuilt on the CPU when residency changes. Its leaves are copies of the pages'
// roots, whose references are moved to count from the copy; so a traversal enters a page without noticing.
// Pages with large roots are opened: their root's children take its place in the build, which lets the top level sort
// parts of overlapping zones (partial re-braiding: Benthin, Woop, Wald & Áfra 2017, "Improved two-level BVHs using
// partial re-braiding"). The build is top down by binned SAH (Wald 2007), straight to eight children a node.
// Thread-safe: no state. Deterministic.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "shaders/shared/page_node.h"

namespace zc {

// What the top level needs of a page; taken when the page is uploaded.
struct PageRoot {
  gpu::PageNode root{};
  std::array<gpu::PageNode, gpu::kNodeWidth> children{};  // as many as the root has child nodes
  std::uint32_t depth = 1;                                // nodes on the page's longest path
  std::uint32_t triangle_count = 0;
};
PageRoot page_root(std::span<const std::uint32_t> page);

struct TracedPage {
  std::uint32_t page_word = 0;  // in the pool
  const PageRoot* root = nullptr;
};

struct TopLevel {
  std::vector<gpu::PageNode> nodes;  // node 0 is the root, also when there is no page
  std::uint32_t depth = 1;           // nodes on the longest path, down to the deepest page's triangles
};

// Most nodes that build_top_level makes for so many pages, and the deepest top level above the pages' roots.
std::uint32_t top_level_node_bound(std::uint32_t pages);
std::uint32_t top_level_depth_bound(std::uint32_t pages);

// first_word: where nodes[0] will lie in the pool.
TopLevel build_top_level(std::span<const TracedPage> pages, std::uint32_t first_word);

}  // namespace zc
