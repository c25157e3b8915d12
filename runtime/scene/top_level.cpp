// SPDX-License-Identifier: Apache-2.0
#include "runtime/scene/top_level.h"

#include <algorithm>
#include <bit>

namespace zc {
namespace {

constexpr std::uint32_t kSahLevels = 3;  // below, splits halve the count: the depth stays bounded

constexpr std::size_t opened_items(std::size_t pages) { return pages / 2 + gpu::kNodeWidth; }

}  // namespace

std::uint32_t top_level_node_bound(std::uint32_t pages) {
  // Every inner node has at least two children, so there are fewer of them than items; and the root.
  const auto items = pages + static_cast<std::uint32_t>(opened_items(pages));
  return 2 * items + 1;
}

std::uint32_t top_level_depth_bound(std::uint32_t pages) {
  const auto items = pages + static_cast<std::uint32_t>(opened_items(pages));
  std::uint32_t depth = kSahLevels;
  for (std::uint64_t reached = 1; reached < items; reached *= gpu::kNodeWidth) ++depth;
  return depth;
}

TracedPage traced_page(std::uint32_t page_word, const PageRoot& root, const std::byte* page) {
  return {page_word, &root, page + 4 * gpu::kPageHeaderWords, page + std::size_t{4} * root.child_words};
}

void TopLevelBuilder::reserve(std::uint32_t pages, std::span<gpu::PageNode> nodes) {
  const std::size_t items = pages + opened_items(pages);
  items_.reserve(items);
  boxes_.reserve(items);
  order_.reserve(items);
  split_.reserve(items);
  by_area_.reserve(pages);
  nodes_ = nodes;
}

void TopLevelBuilder::build(std::span<const TracedPage> pages, std::uint32_t first_word) {
  first_word_ = first_word;
  depth_ = 1;
  node_count_ = 1;
  const std::size_t bound = top_level_node_bound(static_cast<std::uint32_t>(pages.size()));
  if (nodes_.size() < bound) {
    own_nodes_.resize(bound);
    nodes_ = own_nodes_;
  }
  if (pages.empty()) {
    nodes_[0] = pack_boxes({});
    return;
  }
  make_items(pages);
  split_.begin(boxes_);
  order_.resize(items_.size());
  for (std::uint32_t i = 0; i < order_.size(); ++i) order_[i] = i;
  build_node(0, order_, 1);
}

void TopLevelBuilder::put_item(std::size_t place, const Item& item, const NodeBox& box) {
  if (place == items_.size()) {
    items_.push_back(item);
    boxes_.push_back(box);
  } else {
    items_[place] = item;
    boxes_[place] = box;
  }
}

// Puts the children of a page's root, and the root's own triangles, in the place of the root.
void TopLevelBuilder::open_page(const TracedPage& page, std::size_t place) {
  const PageRoot& root = *page.root;
  for (std::uint32_t c = 0; c < root.child_count; ++c) {
    const std::byte* child = page.children + c * sizeof(gpu::PageNode);
    put_item(c == 0 ? place : items_.size(),
             {child, page.page_word + root.child_words + c * gpu::kPageNodeWords, root.depth - 1},
             node_bounds(load_node(child)));
  }
  const gpu::PageNode node = load_node(page.root_node);
  if (leaf_mask(node) != 0)
    put_item(items_.size(), {page.root_node, page.page_word + gpu::kPageHeaderWords, 1, ~(0xFFU << 16)},
             bounds_of_slots(node, leaf_mask(node)));
}

// One item a page, except that the largest roots are opened while there is room.
void TopLevelBuilder::make_items(std::span<const TracedPage> pages) {
  items_.clear();
  boxes_.clear();
  for (const TracedPage& page : pages)
    put_item(items_.size(), {page.root_node, page.page_word + gpu::kPageHeaderWords, page.root->depth}, page.root->box);
  if (pages.size() < 2) return;

  // The largest area first, of equal ones the first page. Only some of them ever leave the heap.
  by_area_.clear();
  for (std::uint32_t i = 0; i < pages.size(); ++i)
    if (pages[i].root->child_count > 0)
      by_area_.push_back(std::uint64_t{std::bit_cast<std::uint32_t>(pages[i].root->half_area)} << 32 | ~i);
  std::ranges::make_heap(by_area_);
  std::size_t room = opened_items(pages.size());
  for (auto end = by_area_.end(); end != by_area_.begin(); --end) {
    const auto i = ~static_cast<std::uint32_t>(by_area_.front());
    const PageRoot& root = *pages[i].root;
    const std::size_t more = root.child_count - (leaf_mask(load_node(pages[i].root_node)) != 0 ? 0U : 1U);
    if (more > room) break;
    room -= more;
    open_page(pages[i], i);
    std::ranges::pop_heap(by_area_.begin(), end);
  }
}

// Puts the items of small parts in their place, as far as there is room: a node less to visit. First where that saves
// most for a place.
void TopLevelBuilder::dissolve(Parts& parts) const {
  while (parts.count < gpu::kNodeWidth) {
    float best = 0;
    std::size_t chosen = parts.count;
    for (std::size_t i = 0; i < parts.count; ++i) {
      const std::size_t more = parts.items[i].size() - 1;
      if (more == 0 || parts.count + more > gpu::kNodeWidth) continue;
      const float gain = parts.boxes[i].half_area() / static_cast<float>(more);
      if (chosen < parts.count && gain <= best) continue;
      best = gain;
      chosen = i;
    }
    if (chosen == parts.count) return;
    const Part whole = parts.items[chosen];
    for (std::size_t k = 0; k < whole.size(); ++k)
      parts.put(k == 0 ? chosen : parts.count++, whole.subspan(k, 1), split_.box(whole[k]));
  }
}

// Up to eight parts. Each time the one is divided that promises most among those that are too many for a node.
void TopLevelBuilder::divide(Part items, std::uint32_t level, Parts& parts) {
  // Below the SAH levels the fullest part is divided, so that the depth is a logarithm.
  const bool by_count = level > kSahLevels;
  parts.add(items, FloatBox::none());
  while (parts.count < gpu::kNodeWidth) {
    float best = -1;
    std::size_t chosen = parts.count;
    for (std::size_t i = 0; i < parts.count; ++i) {
      if (parts.items[i].size() <= (by_count ? 1 : gpu::kNodeWidth)) continue;
      const float size = by_count           ? static_cast<float>(parts.items[i].size())
                         : parts.count == 1 ? 0
                                            : parts.boxes[i].half_area();
      if (size <= best) continue;
      best = size;
      chosen = i;
    }
    if (chosen == parts.count) break;
    const Part whole = parts.items[chosen];
    const BoxSplit::Halves halves = by_count ? split_.by_count(whole) : split_.by_area(whole);
    parts.put(chosen, whole.first(halves.first), halves.left);
    parts.add(whole.subspan(halves.first), halves.right);
  }
  dissolve(parts);
}

// Fills nodes_[index], whose children lie one after the other.
NodeBox TopLevelBuilder::build_node(std::uint32_t index, Part items, std::uint32_t level) {
  Parts parts;
  if (items.size() > gpu::kNodeWidth) {
    divide(items, level, parts);
  } else {
    for (std::size_t i = 0; i < items.size(); ++i) parts.add(items.subspan(i, 1), split_.box(items[i]));
  }
  std::array<NodeBox, gpu::kNodeWidth> about;  // boxes, but for what floats round
  for (std::size_t i = 0; i < parts.count; ++i) about[i] = to_node_box(parts.boxes[i]);
  const auto part_of_slot = assign_slots(std::span(about).first(parts.count));
  const std::uint32_t first_child = node_count_;
  node_count_ += static_cast<std::uint32_t>(parts.count);
  std::array<NodeBox, gpu::kNodeWidth> boxes;
  NodeBox all;
  std::uint32_t mask = 0;
  std::uint32_t child = first_child;
  for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
    if (part_of_slot[slot] < 0) continue;
    const Part inside = parts.items[static_cast<std::size_t>(part_of_slot[slot])];
    if (inside.size() == 1) {
      place_item(child, items_[inside[0]], level);
      boxes[slot] = boxes_[inside[0]];
    } else {
      boxes[slot] = build_node(child, inside, level + 1);
    }
    all.add(boxes[slot]);
    mask |= 1U << slot;
    ++child;
  }
  gpu::PageNode node = pack_boxes(boxes);
  node.exponents_masks |= mask << 16;
  node.child_offset = (first_child - index) * gpu::kPageNodeWords;
  nodes_[index] = node;
  return all;
}

void TopLevelBuilder::place_item(std::uint32_t index, const Item& item, std::uint32_t level) {
  // References count in words modulo 2^32: a copy behind its page refers backwards.
  const std::uint32_t moved = item.word - (first_word_ + index * gpu::kPageNodeWords);
  gpu::PageNode node = load_node(item.node);
  node.exponents_masks &= item.kept_masks;
  node.child_offset += moved;
  node.triangle_offset += moved;
  node.cluster_offset += moved;
  nodes_[index] = node;
  depth_ = std::max(depth_, level + item.depth);
}

}  // namespace zc
