// SPDX-License-Identifier: Apache-2.0
#include "runtime/top_level.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <queue>

#include "base/check.h"

namespace zc {
namespace {

constexpr std::uint32_t kBins = 8;
constexpr std::uint32_t kSahDepth = 3;  // below, splits halve the count: the depth stays bounded

// A node that becomes a leaf of the top level: a page's root, or a part of it.
struct Item {
  NodeBox box;
  std::array<std::int64_t, 3> center{};  // doubled
  gpu::PageNode node;
  std::uint32_t word = 0;  // where the node's references count from
  std::uint32_t depth = 1;
};

NodeBox bounds(const gpu::PageNode& node) {
  NodeBox all;
  for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
    if (((inner_mask(node) | leaf_mask(node)) >> slot & 1U) == 0) continue;
    const WideNodeBox box = child_box(node, slot);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      all.min[axis] = static_cast<std::int32_t>(std::min<std::int64_t>(all.min[axis], box.min[axis]));
      all.max[axis] = static_cast<std::int32_t>(std::max<std::int64_t>(all.max[axis], box.max[axis]));
    }
  }
  return all;
}

Item make_item(const gpu::PageNode& node, std::uint32_t word, std::uint32_t depth) {
  Item item{bounds(node), {}, node, word, depth};
  for (std::size_t axis = 0; axis < 3; ++axis)
    item.center[axis] = std::int64_t{item.box.min[axis]} + item.box.max[axis];
  return item;
}

std::size_t opened_items(std::size_t pages) { return pages / 2 + gpu::kNodeWidth; }

// One item a page, except that the largest roots are replaced by their children while there is room.
std::vector<Item> make_items(std::span<const TracedPage> pages) {
  std::vector<Item> items;
  items.reserve(pages.size() + opened_items(pages.size()));
  for (const TracedPage& page : pages)
    items.push_back(make_item(page.root->root, page.page_word + gpu::kPageHeaderWords, page.root->depth));
  if (pages.size() < 2) return items;

  std::vector<std::uint32_t> by_area(pages.size());
  std::vector<double> area(pages.size());
  for (std::uint32_t i = 0; i < pages.size(); ++i) {
    by_area[i] = i;
    area[i] = items[i].box.half_area();
  }
  std::ranges::sort(by_area, [&](std::uint32_t a, std::uint32_t b) { return area[a] != area[b] ? area[a] > area[b] : a < b; });
  std::size_t room = opened_items(pages.size());
  for (const std::uint32_t i : by_area) {
    const gpu::PageNode root = items[i].node;
    const std::uint32_t root_word = items[i].word;
    const auto children = static_cast<std::uint32_t>(std::popcount(inner_mask(root)));
    const bool leaves = leaf_mask(root) != 0;
    const std::uint32_t parts = children + (leaves ? 1U : 0U);
    if (children == 0) continue;
    if (parts - 1 > room) break;
    room -= parts - 1;
    for (std::uint32_t c = 0; c < children; ++c) {
      const Item part = make_item(pages[i].root->children[c], root_word + root.child_offset + c * gpu::kPageNodeWords,
                                  pages[i].root->depth - 1);
      if (c == 0) {
        items[i] = part;
      } else {
        items.push_back(part);
      }
    }
    if (leaves) {  // what is left of the root: its own triangles
      gpu::PageNode rest = root;
      rest.exponents_masks &= ~(0xFFU << 16);
      items.push_back(make_item(rest, root_word, 1));
    }
  }
  return items;
}

class Builder {
 public:
  Builder(std::vector<Item> items, std::uint32_t first_word) : items_(std::move(items)), first_word_(first_word) {}

  TopLevel run() {
    top_.nodes.reserve(2 * items_.size() + 1);
    top_.nodes.emplace_back(pack_boxes({}));
    if (!items_.empty()) {
      order_.resize(items_.size());
      for (std::uint32_t i = 0; i < order_.size(); ++i) order_[i] = i;
      build(0, order_, 1);
    }
    return std::move(top_);
  }

 private:
  struct Part {
    std::span<std::uint32_t> items;
    NodeBox box;
  };

  Part make_part(std::span<std::uint32_t> items) const {
    Part part{items, {}};
    for (const std::uint32_t i : items) part.box.add(items_[i].box);
    return part;
  }

  std::size_t split_at_median(std::span<std::uint32_t> items, std::size_t axis) const {
    const std::size_t middle = items.size() / 2;
    std::ranges::nth_element(items, items.begin() + static_cast<std::ptrdiff_t>(middle), [&](std::uint32_t a, std::uint32_t b) {
      const auto ca = items_[a].center[axis];
      const auto cb = items_[b].center[axis];
      return ca != cb ? ca < cb : a < b;
    });
    return middle;
  }

  // Arranges the items of a part and returns the size of its first half.
  std::size_t split(std::span<std::uint32_t> items, std::uint32_t depth) const {
    std::array<std::int64_t, 3> low = items_[items[0]].center;
    std::array<std::int64_t, 3> high = low;
    for (const std::uint32_t i : items) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], items_[i].center[axis]);
        high[axis] = std::max(high[axis], items_[i].center[axis]);
      }
    }
    std::size_t widest = 0;
    for (std::size_t axis = 1; axis < 3; ++axis)
      if (high[axis] - low[axis] > high[widest] - low[widest]) widest = axis;
    if (depth > kSahDepth || high[widest] == low[widest]) return split_at_median(items, widest);
    const auto bin_of = [&](std::uint32_t i, std::size_t axis) {
      return static_cast<std::uint32_t>((items_[i].center[axis] - low[axis]) * kBins / (high[axis] - low[axis] + 1));
    };
    double best_cost = std::numeric_limits<double>::infinity();
    std::size_t best_axis = widest;
    std::uint32_t best_bin = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (high[axis] == low[axis]) continue;
      std::array<NodeBox, kBins> boxes;
      std::array<std::uint32_t, kBins> counts{};
      for (const std::uint32_t i : items) {
        const std::uint32_t bin = bin_of(i, axis);
        boxes[bin].add(items_[i].box);
        ++counts[bin];
      }
      std::array<double, kBins> right_cost{};
      NodeBox right;
      std::uint32_t right_count = 0;
      for (std::uint32_t bin = kBins - 1; bin > 0; --bin) {
        right.add(boxes[bin]);
        right_count += counts[bin];
        right_cost[bin] = right.half_area() * right_count;
      }
      NodeBox left;
      std::uint32_t left_count = 0;
      for (std::uint32_t bin = 0; bin + 1 < kBins; ++bin) {
        left.add(boxes[bin]);
        left_count += counts[bin];
        if (left_count == 0 || left_count == items.size()) continue;
        const double cost = left.half_area() * left_count + right_cost[bin + 1];
        if (cost < best_cost) {
          best_cost = cost;
          best_axis = axis;
          best_bin = bin;
        }
      }
    }
    const auto second = std::ranges::partition(items, [&](std::uint32_t i) { return bin_of(i, best_axis) <= best_bin; });
    return items.size() - second.size();
  }

  // Fills nodes[index], whose children lie one after the other.
  void build(std::uint32_t index, std::span<std::uint32_t> items, std::uint32_t depth) {
    std::vector<Part> parts = {make_part(items)};
    while (parts.size() < gpu::kNodeWidth) {
      double largest = -1;
      std::size_t chosen = 0;
      for (std::size_t i = 0; i < parts.size(); ++i) {
        // Below the SAH levels the fullest part is divided, so that the depth is a logarithm.
        const double size =
            depth > kSahDepth ? static_cast<double>(parts[i].items.size()) : parts[i].box.half_area();
        if (parts[i].items.size() > 1 && size > largest) {
          largest = size;
          chosen = i;
        }
      }
      if (largest < 0) break;
      const std::span<std::uint32_t> whole = parts[chosen].items;
      const std::size_t first = split(whole, depth);
      parts[chosen] = make_part(whole.first(first));
      parts.push_back(make_part(whole.subspan(first)));
    }

    std::array<NodeBox, gpu::kNodeWidth> child_boxes;
    for (std::size_t i = 0; i < parts.size(); ++i) child_boxes[i] = parts[i].box;
    const auto child_of_slot = assign_slots(std::span(child_boxes).first(parts.size()));
    std::array<NodeBox, gpu::kNodeWidth> slot_boxes;
    std::uint32_t mask = 0;
    for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
      if (child_of_slot[slot] < 0) continue;
      slot_boxes[slot] = child_boxes[static_cast<std::size_t>(child_of_slot[slot])];
      mask |= 1U << slot;
    }
    gpu::PageNode node = pack_boxes(slot_boxes);
    node.exponents_masks |= mask << 16;
    const auto first_child = static_cast<std::uint32_t>(top_.nodes.size());
    node.child_offset = (first_child - index) * gpu::kPageNodeWords;
    top_.nodes[index] = node;
    top_.nodes.resize(top_.nodes.size() + parts.size());
    std::uint32_t child = first_child;
    for (const int part : child_of_slot) {
      if (part < 0) continue;
      const std::span<std::uint32_t> inside = parts[static_cast<std::size_t>(part)].items;
      if (inside.size() == 1) {
        place(child, items_[inside[0]], depth);
      } else {
        build(child, inside, depth + 1);
      }
      ++child;
    }
  }

  void place(std::uint32_t index, const Item& item, std::uint32_t depth) {
    // References count in words modulo 2^32: a copy behind its page refers backwards.
    const std::uint32_t moved = item.word - (first_word_ + index * gpu::kPageNodeWords);
    gpu::PageNode node = item.node;
    node.child_offset += moved;
    node.triangle_offset += moved;
    node.cluster_offset += moved;
    top_.nodes[index] = node;
    top_.depth = std::max(top_.depth, depth + item.depth);
  }

  std::vector<Item> items_;
  std::uint32_t first_word_;
  std::vector<std::uint32_t> order_;
  TopLevel top_;
};

}  // namespace

PageRoot page_root(std::span<const std::uint32_t> page) {
  ZC_CHECK(page.size() >= gpu::kPageHeaderWords + gpu::kPageNodeWords);
  gpu::PageHeader header;
  std::memcpy(&header, page.data(), sizeof header);
  PageRoot out;
  out.depth = header.depth;
  out.triangle_count = header.triangle_count;
  std::memcpy(&out.root, page.data() + gpu::kPageHeaderWords, sizeof out.root);
  const auto children = static_cast<std::size_t>(std::popcount(inner_mask(out.root)));
  const std::size_t at = gpu::kPageHeaderWords + std::size_t{out.root.child_offset};
  ZC_CHECK(children == 0 || at + children * gpu::kPageNodeWords <= page.size());
  if (children > 0) std::memcpy(out.children.data(), page.data() + at, children * sizeof(gpu::PageNode));
  return out;
}

std::uint32_t top_level_node_bound(std::uint32_t pages) {
  // Every inner node has at least two children, so there are fewer of them than items; and the root.
  const auto items = pages + static_cast<std::uint32_t>(opened_items(pages));
  return 2 * items + 1;
}

std::uint32_t top_level_depth_bound(std::uint32_t pages) {
  const auto items = pages + static_cast<std::uint32_t>(opened_items(pages));
  std::uint32_t depth = kSahDepth;
  for (std::uint64_t held = 1; held < items; held *= gpu::kNodeWidth) ++depth;
  return depth;
}

TopLevel build_top_level(std::span<const TracedPage> pages, std::uint32_t first_word) {
  return Builder(make_items(pages), first_word).run();
}

}  // namespace zc
