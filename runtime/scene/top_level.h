// SPDX-License-Identifier: Apache-2.0
// The top-level BVH over resident zones, rebuilt on the CPU when residency changes. Its leaves are copies of the pages'
// roots, whose references are moved to count from the copy; so a traversal enters a page without noticing.
// Pages with large roots are opened: their root's children take its place in the build, which lets the top level sort
// parts of overlapping zones (partial re-braiding: Benthin, Woop, Wald & Áfra 2017, "Improved two-level BVHs using
// partial re-braiding"). The build is top down by SAH (box_split.h), straight to eight children a node.
// Deterministic: the same pages give the same bytes, whatever was built before. Threads: one builder at a time.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "runtime/scene/box_split.h"
#include "runtime/scene/page_root.h"

namespace zc {

struct TracedPage {
  std::uint32_t page_word = 0;  // in the pool
  const PageRoot* root = nullptr;
  const std::byte* root_node = nullptr;  // as it lies in the page; and the root's children
  const std::byte* children = nullptr;
};
// Of a page that lies in memory as a whole.
TracedPage traced_page(std::uint32_t page_word, const PageRoot& root, const std::byte* page);

// Most nodes that a build makes for so many pages, and the deepest top level above the pages' roots. The first is at
// most kTopLevelFixedNodes + pages * kTopLevelNodesPerPage.
std::uint32_t top_level_node_bound(std::uint32_t pages);
inline constexpr std::uint32_t kTopLevelNodesPerPage = 3;
inline constexpr std::uint32_t kTopLevelFixedNodes = 2 * gpu::kNodeWidth + 1;
std::uint32_t top_level_depth_bound(std::uint32_t pages);

// Keeps its memory from one build to the next.
class TopLevelBuilder {
 public:
  // Takes the memory of builds of at most so many pages at once: kFixedBytes and kBytesPerPage each.
  // nodes: where builds put theirs, top_level_node_bound(pages) of them.
  void reserve(std::uint32_t pages, std::span<gpu::PageNode> nodes);

  // first_word: where nodes()[0] will lie in the pool.
  void build(std::span<const TracedPage> pages, std::uint32_t first_word);

  // Node 0 is the root, also when there is no page. Until the next build.
  [[nodiscard]] std::span<const gpu::PageNode> nodes() const { return {nodes_.data(), node_count_}; }
  // Nodes on the longest path, down to the deepest page's triangles.
  [[nodiscard]] std::uint32_t depth() const { return depth_; }

 private:
  // What becomes a leaf of the top level: a page's root, or a part of it.
  struct Item {
    const std::byte* node = nullptr;
    std::uint32_t word = 0;  // where the node's references count from
    std::uint32_t depth = 1;
    std::uint32_t kept_masks = 0xFFFFFFFFU;  // of an opened page's root only the leaves are left
  };
  using Part = std::span<std::uint32_t>;  // numbers of items
  struct Parts {
    std::array<Part, gpu::kNodeWidth> items;
    std::array<FloatBox, gpu::kNodeWidth> boxes;
    std::size_t count = 0;

    void put(std::size_t i, Part part, const FloatBox& box) {
      items[i] = part;
      boxes[i] = box;
    }
    void add(Part part, const FloatBox& box) { put(count++, part, box); }
  };

  void make_items(std::span<const TracedPage> pages);
  void open_page(const TracedPage& page, std::size_t place);
  void put_item(std::size_t place, const Item& item, const NodeBox& box);
  void divide(Part items, std::uint32_t level, Parts& parts);
  void dissolve(Parts& parts) const;
  // Returns what is in it.
  NodeBox build_node(std::uint32_t index, Part items, std::uint32_t level);
  void place_item(std::uint32_t index, const Item& item, std::uint32_t level);

  std::uint32_t first_word_ = 0;
  std::vector<Item> items_;
  std::vector<NodeBox> boxes_;  // of items_
  std::vector<std::uint64_t> by_area_;
  std::vector<std::uint32_t> order_;
  BoxSplit split_;
  std::vector<gpu::PageNode> own_nodes_;  // of who reserved nothing
  std::span<gpu::PageNode> nodes_;
  std::uint32_t node_count_ = 0;
  std::uint32_t depth_ = 1;

  static constexpr std::uint64_t kBytesPerItem =
      sizeof(Item) + sizeof(NodeBox) + sizeof(std::uint32_t) + BoxSplit::kBytesPerBox;

 public:
  // Items are at most kNodeWidth more than one and a half a page.
  static constexpr std::uint64_t kFixedBytes = gpu::kNodeWidth * kBytesPerItem;
  static constexpr std::uint64_t kBytesPerPage = (3 * kBytesPerItem + 1) / 2 + sizeof(std::uint64_t);
};

}  // namespace zc
