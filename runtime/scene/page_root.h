// SPDX-License-Identifier: Apache-2.0
// What the top level needs of a page beside the nodes themselves, taken once, when the page is uploaded.
// The page is one that verify_page passed. Thread-safe: no state.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "shaders/shared/page_node.h"

namespace zc {

struct PageRoot {
  std::uint32_t child_words = 0;  // where in the page the root's children lie, one after the other
  std::uint32_t child_count = 0;
  std::uint32_t depth = 1;  // nodes on the page's longest path
  std::uint32_t triangle_count = 0;
  float half_area = 0;  // of `box`
  NodeBox box;          // of all that is in the root
};

PageRoot page_root(std::span<const std::uint32_t> page);

// Of all that is in a node.
NodeBox node_bounds(const gpu::PageNode& node);

// A node as it lies in a page.
gpu::PageNode load_node(const std::byte* at);

}  // namespace zc
