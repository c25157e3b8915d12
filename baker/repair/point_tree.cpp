// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/repair/point_tree.h"

#include <algorithm>

namespace zc {
namespace {

constexpr std::uint32_t kLeafPoints = 8;

}  // namespace

PointTree::PointTree(const std::vector<LatticePoint>& points, std::vector<std::uint32_t> indices)
    : indices_(std::move(indices)) {
  if (indices_.empty()) return;
  nodes_.emplace_back();
  nodes_[0].count = static_cast<std::uint32_t>(indices_.size());
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    Node node = nodes_[i];
    for (std::uint32_t k = node.first; k < node.first + node.count; ++k) node.box.add(points[indices_[k]]);
    if (node.count > kLeafPoints) {
      std::size_t axis = 0;
      const auto side = [&](std::size_t k) { return std::int64_t{node.box.max[k]} - node.box.min[k]; };
      for (std::size_t k = 1; k < 3; ++k)
        if (side(k) > side(axis)) axis = k;
      const auto begin = indices_.begin() + node.first;
      const std::uint32_t half = node.count / 2;
      std::nth_element(begin, begin + half, begin + node.count, [&](std::uint32_t l, std::uint32_t r) {
        return points[l][axis] != points[r][axis] ? points[l][axis] < points[r][axis] : l < r;
      });
      node.left = static_cast<std::uint32_t>(nodes_.size());
      Node left;
      left.first = node.first;
      left.count = half;
      Node right;
      right.first = node.first + half;
      right.count = node.count - half;
      nodes_.push_back(left);
      nodes_.push_back(right);
    }
    nodes_[i] = node;
  }
}

bool PointTree::intersects(const LatticeBox& box, const LatticePoint& a, const LatticePoint& b) {
  double enter = 0;
  double leave = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double low = double(box.min[axis]) - 1 - a[axis];
    const double high = double(box.max[axis]) + 1 - a[axis];
    const double along = double(b[axis]) - a[axis];
    if (along == 0) {
      if (low > 0 || high < 0) return false;
      continue;
    }
    const double first = low / along;
    const double second = high / along;
    enter = std::max(enter, std::min(first, second));
    leave = std::min(leave, std::max(first, second));
  }
  return enter <= leave;
}

}  // namespace zc
