// SPDX-License-Identifier: Apache-2.0
#include "runtime/top_level.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "shaders/shared/page.h"

namespace zc {
namespace {

// Below this depth splits halve the count, so that the traversal stack stays bounded: 24 + log2(2^16) levels at most.
constexpr std::uint32_t kSahDepth = 24;

ZoneBounds empty_bounds() {
  constexpr std::int32_t low = std::numeric_limits<std::int32_t>::min();
  constexpr std::int32_t high = std::numeric_limits<std::int32_t>::max();
  return {{high, high, high}, {low, low, low}};
}

void grow(ZoneBounds& bounds, const ZoneBounds& other) {
  for (std::size_t i = 0; i < 3; ++i) {
    bounds.min[i] = std::min(bounds.min[i], other.min[i]);
    bounds.max[i] = std::max(bounds.max[i], other.max[i]);
  }
}

double half_area(const ZoneBounds& b) {
  const double x = static_cast<double>(b.max[0]) - b.min[0];
  const double y = static_cast<double>(b.max[1]) - b.min[1];
  const double z = static_cast<double>(b.max[2]) - b.min[2];
  return x * y + y * z + z * x;
}

class Builder {
 public:
  explicit Builder(std::span<const ZoneBounds> zones) : zones_(zones), order_(zones.size()) {
    std::iota(order_.begin(), order_.end(), 0U);
  }

  TopLevel run() {
    top_.nodes.reserve(std::max<std::size_t>(1, zones_.size()));
    if (zones_.size() < 2) {
      gpu::TopNode root{};
      root.ref0 = zones_.empty() ? gpu::kRefNone : gpu::kRefLeaf;
      root.ref1 = gpu::kRefNone;
      if (!zones_.empty()) set_child(root, 0, zones_[0]);
      top_.nodes.push_back(root);
    } else {
      split(order_, 1);
    }
    return std::move(top_);
  }

 private:
  static void set_child(gpu::TopNode& node, int child, const ZoneBounds& b) {
    if (child == 0) {
      node.min0_x = b.min[0], node.min0_y = b.min[1], node.min0_z = b.min[2];
      node.max0_x = b.max[0], node.max0_y = b.max[1], node.max0_z = b.max[2];
    } else {
      node.min1_x = b.min[0], node.min1_y = b.min[1], node.min1_z = b.min[2];
      node.max1_x = b.max[0], node.max1_y = b.max[1], node.max1_z = b.max[2];
    }
  }

  [[nodiscard]] std::int64_t doubled_center(std::uint32_t zone, std::size_t axis) const {
    return static_cast<std::int64_t>(zones_[zone].min[axis]) + zones_[zone].max[axis];
  }

  void sort(std::span<std::uint32_t> items, std::size_t axis) const {
    std::ranges::sort(items, [&](std::uint32_t a, std::uint32_t b) {
      const auto ca = doubled_center(a, axis);
      const auto cb = doubled_center(b, axis);
      return ca != cb ? ca < cb : a < b;
    });
  }

  // Leaves `items` sorted along the best axis and returns the size of the left side.
  std::size_t best_split(std::span<std::uint32_t> items, std::uint32_t depth) const {
    double best_cost = std::numeric_limits<double>::infinity();
    std::size_t best_axis = 0;
    std::size_t best_left = items.size() / 2;
    std::vector<double> right_cost(items.size());
    for (std::size_t axis = 0; axis < 3; ++axis) {
      sort(items, axis);
      ZoneBounds bounds = empty_bounds();
      for (std::size_t i = items.size(); i-- > 1;) {
        grow(bounds, zones_[items[i]]);
        right_cost[i] = half_area(bounds) * static_cast<double>(items.size() - i);
      }
      bounds = empty_bounds();
      for (std::size_t left = 1; left < items.size(); ++left) {
        grow(bounds, zones_[items[left - 1]]);
        if (depth > kSahDepth && left != items.size() / 2) continue;
        const double cost = half_area(bounds) * static_cast<double>(left) + right_cost[left];
        if (cost < best_cost) {
          best_cost = cost;
          best_axis = axis;
          best_left = left;
        }
      }
    }
    sort(items, best_axis);
    return best_left;
  }

  std::uint32_t split(std::span<std::uint32_t> items, std::uint32_t depth) {
    const auto index = static_cast<std::uint32_t>(top_.nodes.size());
    top_.depth = std::max(top_.depth, depth);
    top_.nodes.emplace_back();
    const std::size_t left = best_split(items, depth);
    const std::array<std::span<std::uint32_t>, 2> sides = {items.first(left), items.subspan(left)};
    std::array<std::uint32_t, 2> refs{};
    for (int child = 0; child < 2; ++child) {
      const auto side = sides[static_cast<std::size_t>(child)];
      ZoneBounds bounds = empty_bounds();
      for (const std::uint32_t zone : side) grow(bounds, zones_[zone]);
      refs[static_cast<std::size_t>(child)] = side.size() == 1 ? (gpu::kRefLeaf | side[0]) : split(side, depth + 1);
      set_child(top_.nodes[index], child, bounds);
    }
    top_.nodes[index].ref0 = refs[0];
    top_.nodes[index].ref1 = refs[1];
    return index;
  }

  std::span<const ZoneBounds> zones_;
  std::vector<std::uint32_t> order_;
  TopLevel top_;
};

}  // namespace

TopLevel build_top_level(std::span<const ZoneBounds> zones) { return Builder(zones).run(); }

}  // namespace zc
