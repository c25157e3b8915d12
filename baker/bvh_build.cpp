// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/bvh_build.h"

#include <algorithm>
#include <vector>

namespace zc {
namespace {

constexpr std::uint32_t kBins = 16;
constexpr std::uint32_t kLeafTriangles = 4;
static_assert(kLeafTriangles <= gpu::kLeafMaxTriangles);
constexpr std::int64_t kTraversalCost = 1;  // of one inner node against one triangle

struct Box {
  std::array<std::uint16_t, 3> min = {65535, 65535, 65535};
  std::array<std::uint16_t, 3> max = {0, 0, 0};

  void add(const Box& b) {
    for (std::size_t i = 0; i < 3; ++i) {
      min[i] = std::min(min[i], b.min[i]);
      max[i] = std::max(max[i], b.max[i]);
    }
  }
  // Half the surface; exact, below 2^34.
  [[nodiscard]] std::int64_t area() const {
    if (min[0] > max[0]) return 0;
    const std::int64_t x = max[0] - min[0];
    const std::int64_t y = max[1] - min[1];
    const std::int64_t z = max[2] - min[2];
    return x * y + y * z + z * x;
  }
};

struct Item {
  Box box;
  std::uint32_t triangle = 0;
  [[nodiscard]] std::uint32_t center(std::size_t axis) const {  // twice the centroid of the box
    return std::uint32_t{box.min[axis]} + box.max[axis];
  }
};

// Inner nodes on the longest path when n items are halved until they fit leaves.
std::uint32_t median_depth(std::size_t n) {
  std::uint32_t depth = 0;
  for (; n > kLeafTriangles; n = (n + 1) / 2) ++depth;
  return depth;
}

class Builder {
 public:
  explicit Builder(std::vector<Item> items) : items_(std::move(items)) { nodes_.reserve(items_.size()); }

  BvhFile run() {
    Box all;
    for (const Item& item : items_) all.add(item.box);
    if (items_.size() <= kLeafTriangles && !find_split(0, items_.size(), all, 1).found) {
      // The page needs a root: its second child is absent.
      nodes_.push_back(make_node(all, leaf_ref(0, items_.size()), Box{}, gpu::kRefNone));
      depth_ = 1;
    } else {
      build(0, items_.size(), all, 1);
    }
    BvhFile out;
    out.depth = depth_;
    out.nodes = std::move(nodes_);
    out.order.reserve(items_.size());
    for (const Item& item : items_) out.order.push_back(item.triangle);
    return out;
  }

 private:
  struct Split {
    bool found = false;
    std::size_t middle = 0;  // items are arranged
    Box left, right;
  };

  static std::uint32_t leaf_ref(std::size_t first, std::size_t count) {
    return gpu::kRefLeaf | static_cast<std::uint32_t>(count) << gpu::kRefCountShift | static_cast<std::uint32_t>(first);
  }

  static gpu::BvhNode make_node(const Box& b0, std::uint32_t ref0, const Box& b1, std::uint32_t ref1) {
    const auto pack = [](std::uint16_t low, std::uint16_t high) {
      return std::uint32_t{low} | std::uint32_t{high} << 16U;
    };
    return {pack(b0.min[0], b0.min[1]),
            pack(b0.min[2], b0.max[0]),
            pack(b0.max[1], b0.max[2]),
            pack(b1.min[0], b1.min[1]),
            pack(b1.min[2], b1.max[0]),
            pack(b1.max[1], b1.max[2]),
            ref0,
            ref1};
  }

  Box bounds(std::size_t begin, std::size_t end) const {
    Box box;
    for (std::size_t i = begin; i < end; ++i) box.add(items_[i].box);
    return box;
  }

  Split split_at_median(std::size_t begin, std::size_t end, std::size_t axis) {
    const std::size_t middle = begin + (end - begin + 1) / 2;
    const auto at = [&](std::size_t i) { return items_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end), [&](const Item& a, const Item& b) {
      return a.center(axis) != b.center(axis) ? a.center(axis) < b.center(axis) : a.triangle < b.triangle;
    });
    return {true, middle, bounds(begin, middle), bounds(middle, end)};
  }

  // Arranges the items and says where to divide, or that a leaf is cheaper. `depth` counts this node.
  Split find_split(std::size_t begin, std::size_t end, const Box& box, std::uint32_t depth) {
    const std::size_t count = end - begin;
    if (count < 2) return {};
    const std::int64_t leaf_cost = count <= kLeafTriangles ? static_cast<std::int64_t>(count) * box.area() : INT64_MAX;
    std::array<std::uint32_t, 3> low = {UINT32_MAX, UINT32_MAX, UINT32_MAX};
    std::array<std::uint32_t, 3> high = {0, 0, 0};
    for (std::size_t i = begin; i < end; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], items_[i].center(axis));
        high[axis] = std::max(high[axis], items_[i].center(axis));
      }
    }
    std::size_t widest = 0;
    for (std::size_t axis = 1; axis < 3; ++axis)
      if (high[axis] - low[axis] > high[widest] - low[widest]) widest = axis;
    if (high[widest] == low[widest]) return count <= kLeafTriangles ? Split{} : split_at_median(begin, end, widest);

    std::array<std::uint64_t, 3> scale = {};
    for (std::size_t axis = 0; axis < 3; ++axis)
      scale[axis] = (std::uint64_t{kBins} << 32U) / (std::uint64_t{high[axis] - low[axis]} + 1);
    std::int64_t best_cost = INT64_MAX;
    std::size_t best_axis = 0;
    std::uint32_t best_bin = 0;
    std::size_t best_left = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (high[axis] == low[axis]) continue;
      std::array<Box, kBins> boxes;
      std::array<std::size_t, kBins> counts = {};
      for (std::size_t i = begin; i < end; ++i) {
        const std::uint32_t bin = bin_of(items_[i].center(axis), low[axis], scale[axis]);
        boxes[bin].add(items_[i].box);
        ++counts[bin];
      }
      std::array<std::int64_t, kBins> right_cost = {};
      Box right;
      std::size_t right_count = 0;
      for (std::uint32_t bin = kBins - 1; bin > 0; --bin) {
        right.add(boxes[bin]);
        right_count += counts[bin];
        right_cost[bin] = right.area() * static_cast<std::int64_t>(right_count);
      }
      Box left;
      std::size_t left_count = 0;
      for (std::uint32_t bin = 0; bin + 1 < kBins; ++bin) {
        left.add(boxes[bin]);
        left_count += counts[bin];
        if (left_count == 0 || left_count == count) continue;
        const std::int64_t cost = left.area() * static_cast<std::int64_t>(left_count) + right_cost[bin + 1];
        if (cost < best_cost) {
          best_cost = cost;
          best_axis = axis;
          best_bin = bin;
          best_left = left_count;
        }
      }
    }
    if (leaf_cost <= best_cost + kTraversalCost * box.area()) return {};
    const std::size_t larger = std::max(best_left, count - best_left);
    if (depth + median_depth(larger) > gpu::kPageMaxDepth) return split_at_median(begin, end, widest);
    const auto at = [&](std::size_t i) { return items_.begin() + static_cast<std::ptrdiff_t>(i); };
    const auto middle = std::partition(at(begin), at(end), [&](const Item& item) {
      return bin_of(item.center(best_axis), low[best_axis], scale[best_axis]) <= best_bin;
    });
    const auto split = static_cast<std::size_t>(middle - items_.begin());
    return {true, split, bounds(begin, split), bounds(split, end)};
  }

  // scale: bins per unit of centre, 32 fractional bits.
  static std::uint32_t bin_of(std::uint32_t center, std::uint32_t low, std::uint64_t scale) {
    return static_cast<std::uint32_t>((center - low) * scale >> 32U);
  }

  std::uint32_t build(std::size_t begin, std::size_t end, const Box& box, std::uint32_t depth) {
    const Split split = find_split(begin, end, box, depth);
    if (!split.found) return leaf_ref(begin, end - begin);
    depth_ = std::max(depth_, depth);
    const auto index = static_cast<std::uint32_t>(nodes_.size());
    nodes_.emplace_back();
    const std::uint32_t ref0 = build(begin, split.middle, split.left, depth + 1);
    const std::uint32_t ref1 = build(split.middle, end, split.right, depth + 1);
    nodes_[index] = make_node(split.left, ref0, split.right, ref1);
    return index;
  }

  std::vector<Item> items_;
  std::vector<gpu::BvhNode> nodes_;
  std::uint32_t depth_ = 0;
};

}  // namespace

Result<BvhFile> build_bvh(std::span<const std::array<std::uint16_t, 3>> vertices,
                          std::span<const std::array<std::uint32_t, 3>> triangles) {
  if (triangles.empty()) return Error{ErrorCode::kFormat, "a zone without triangles has no BVH"};
  if (triangles.size() > gpu::kRefFirstMask)
    return Error{ErrorCode::kUnsupported,
                 "a zone has " + std::to_string(triangles.size()) + " triangles, more than 2^24"};
  std::vector<Item> items(triangles.size());
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    items[i].triangle = i;
    for (const std::uint32_t v : triangles[i]) {
      if (v >= vertices.size()) return Error{ErrorCode::kFormat, "a triangle refers to a missing vertex"};
      items[i].box.add(Box{vertices[v], vertices[v]});
    }
  }
  return Builder(std::move(items)).run();
}

}  // namespace zc
