// SPDX-License-Identifier: Apache-2.0
#include "replay/bench/engines/sah_tree.h"

#include <algorithm>
#include <numeric>

#include "base/check.h"

namespace zc::bench {
namespace {

constexpr std::size_t kBins = 32;
constexpr std::uint32_t kSweepTriangles = 256;
// Past this depth splits halve their triangles: no input makes the tree deeper than 64.
constexpr std::uint32_t kMedianDepth = 40;

void grow(SahBox& box, const SahBox& other) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.min[axis] = std::min(box.min[axis], other.min[axis]);
    box.max[axis] = std::max(box.max[axis], other.max[axis]);
  }
}

float half_area(const SahBox& box) {
  const float x = box.max[0] - box.min[0];
  const float y = box.max[1] - box.min[1];
  const float z = box.max[2] - box.min[2];
  return x < 0 ? 0 : x * y + y * z + z * x;
}

struct Split {
  float cost = std::numeric_limits<float>::infinity();  // area × triangles, both sides
  std::size_t axis = 0;
  std::uint32_t left = 0;    // triangles, in the order of `axis`; 0: none found
  std::size_t last_bin = 0;  // of the left side; for binned splits
};

class Builder {
 public:
  Builder(std::span<const BenchTriangle> triangles, const SahOptions& options) : options_(options) {
    boxes_.resize(triangles.size());
    centers_.resize(triangles.size());
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      for (std::size_t k = 0; k < 9; ++k) {
        boxes_[i].min[k % 3] = std::min(boxes_[i].min[k % 3], triangles[i].v[k]);
        boxes_[i].max[k % 3] = std::max(boxes_[i].max[k % 3], triangles[i].v[k]);
      }
      for (std::size_t axis = 0; axis < 3; ++axis)
        centers_[i][axis] = 0.5F * boxes_[i].min[axis] + 0.5F * boxes_[i].max[axis];
    }
    tree_.order.resize(triangles.size());
    std::iota(tree_.order.begin(), tree_.order.end(), 0U);
  }

  SahTree run() && {
    tree_.nodes.emplace_back();
    build(0, 0, static_cast<std::uint32_t>(tree_.order.size()), 0);
    return std::move(tree_);
  }

 private:
  [[nodiscard]] std::span<std::uint32_t> range(std::uint32_t first, std::uint32_t count) {
    return std::span(tree_.order).subspan(first, count);
  }

  void build(std::uint32_t node, std::uint32_t first, std::uint32_t count, std::uint32_t depth) {
    SahBox box;
    SahBox centers;
    for (const std::uint32_t i : range(first, count)) {
      grow(box, boxes_[i]);
      grow(centers, {centers_[i], centers_[i]});
    }
    tree_.nodes[node] = {box, first, count};
    if (count == 1) return;
    Split split;
    if (depth < kMedianDepth) split = count <= kSweepTriangles ? sweep(first, count) : bin(first, count, centers);
    const float split_cost = options_.node_cost * half_area(box) + split.cost;
    if (count <= options_.max_leaf && half_area(box) * static_cast<float>(count) <= split_cost) return;
    const std::uint32_t left = split.left > 0 ? part(first, count, centers, split) : halve(first, count, centers);
    const auto children = static_cast<std::uint32_t>(tree_.nodes.size());
    tree_.nodes.resize(tree_.nodes.size() + 2);
    tree_.nodes[node].first = children;
    tree_.nodes[node].count = 0;
    tree_.depth = std::max(tree_.depth, depth + 1);
    build(children, first, left, depth + 1);
    build(children + 1, first + left, count - left, depth + 1);
  }

  void sort_along(std::span<std::uint32_t> order, std::size_t axis) {
    std::ranges::sort(order, [&](std::uint32_t a, std::uint32_t b) {
      return centers_[a][axis] != centers_[b][axis] ? centers_[a][axis] < centers_[b][axis] : a < b;
    });
  }

  Split sweep(std::uint32_t first, std::uint32_t count) {
    Split best;
    std::vector<float> right_area(count);
    std::vector<std::uint32_t> order;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto from = range(first, count);
      order.assign(from.begin(), from.end());
      sort_along(order, axis);
      SahBox right;
      for (std::uint32_t i = count - 1; i > 0; --i) {
        grow(right, boxes_[order[i]]);
        right_area[i] = half_area(right);
      }
      SahBox left;
      for (std::uint32_t i = 1; i < count; ++i) {
        grow(left, boxes_[order[i - 1]]);
        const float cost = half_area(left) * static_cast<float>(i) + right_area[i] * static_cast<float>(count - i);
        if (cost < best.cost) best = {cost, axis, i, 0};
      }
    }
    return best;
  }

  [[nodiscard]] std::size_t bin_of(std::uint32_t triangle, std::size_t axis, const SahBox& centers) const {
    const float extent = centers.max[axis] - centers.min[axis];
    const float place = (centers_[triangle][axis] - centers.min[axis]) / extent * static_cast<float>(kBins);
    return std::min(static_cast<std::size_t>(place), kBins - 1);
  }

  Split bin(std::uint32_t first, std::uint32_t count, const SahBox& centers) {
    Split best;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!(centers.max[axis] > centers.min[axis])) continue;
      std::array<SahBox, kBins> boxes;
      std::array<std::uint32_t, kBins> counts{};
      for (const std::uint32_t i : range(first, count)) {
        const std::size_t bin = bin_of(i, axis, centers);
        grow(boxes[bin], boxes_[i]);
        ++counts[bin];
      }
      std::array<float, kBins> right_area{};
      SahBox right;
      for (std::size_t i = kBins - 1; i > 0; --i) {
        grow(right, boxes[i]);
        right_area[i] = half_area(right);
      }
      SahBox left;
      std::uint32_t left_count = 0;
      for (std::size_t i = 0; i + 1 < kBins; ++i) {
        grow(left, boxes[i]);
        left_count += counts[i];
        if (left_count == 0 || left_count == count) continue;
        const float cost = half_area(left) * static_cast<float>(left_count) +
                           right_area[i + 1] * static_cast<float>(count - left_count);
        if (cost < best.cost) best = {cost, axis, left_count, i};
      }
    }
    return best;
  }

  std::uint32_t part(std::uint32_t first, std::uint32_t count, const SahBox& centers, const Split& split) {
    if (count <= kSweepTriangles) {
      sort_along(range(first, count), split.axis);
      return split.left;
    }
    const auto order = range(first, count);
    const auto middle = std::stable_partition(
        order.begin(), order.end(), [&](std::uint32_t i) { return bin_of(i, split.axis, centers) <= split.last_bin; });
    ZC_CHECK(middle - order.begin() == static_cast<std::ptrdiff_t>(split.left));
    return split.left;
  }

  std::uint32_t halve(std::uint32_t first, std::uint32_t count, const SahBox& centers) {
    std::size_t widest = 0;
    for (std::size_t axis = 1; axis < 3; ++axis)
      if (centers.max[axis] - centers.min[axis] > centers.max[widest] - centers.min[widest]) widest = axis;
    sort_along(range(first, count), widest);
    return count / 2;
  }

  SahOptions options_;
  std::vector<SahBox> boxes_;
  std::vector<std::array<float, 3>> centers_;
  SahTree tree_;
};

}  // namespace

SahTree build_sah_tree(std::span<const BenchTriangle> triangles, const SahOptions& options) {
  ZC_CHECK(!triangles.empty() && options.max_leaf > 0);
  return Builder(triangles, options).run();
}

}  // namespace zc::bench
