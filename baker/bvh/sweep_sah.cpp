// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/bvh/sweep_sah.h"

#include <algorithm>
#include <limits>

#include "baker/bvh/binned_sah.h"
#include "base/check.h"

namespace zc {

void SweepBuilder::grow(BinaryTree& tree, std::uint32_t node, std::span<const PackedBox> references,
                        std::uint32_t depth) {
  tree_ = &tree;
  boxes_ = references;
  sort(references);
  if (right_cost_.size() < references.size()) {
    right_cost_.resize(references.size());
    goes_left_.resize(references.size());
    scratch_.resize(references.size());
  }
  divide(node, 0, references.size(), depth);
}

// By centre, then by place.
void SweepBuilder::sort(std::span<const PackedBox> references) {
  keys_.resize(references.size());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < references.size(); ++i) keys_[i] = std::uint64_t{references[i].center(axis)} << 32U | i;
    std::ranges::sort(keys_);
    order_[axis].resize(references.size());
    for (std::size_t i = 0; i < references.size(); ++i) order_[axis][i] = static_cast<std::uint32_t>(keys_[i]);
  }
}

void SweepBuilder::divide(std::uint32_t index, std::size_t begin, std::size_t end, std::uint32_t depth) {
  PackedBox box;
  for (std::size_t i = begin; i < end; ++i) box.add(boxes_[order_[0][i]]);
  tree_->nodes[index].box = box.box();
  if (end - begin == 1) {
    tree_->nodes[index].reference = static_cast<std::uint32_t>(tree_->references.size());
    tree_->references.push_back(boxes_[order_[0][begin]].reference());
    return;
  }
  std::size_t axis = 0;
  const std::size_t middle = split(begin, end, depth, axis);
  if (end - begin > 2) {
    for (std::size_t i = begin; i < end; ++i) goes_left_[order_[axis][i]] = i < middle ? 1 : 0;
    for (std::size_t other = 0; other < 3; ++other)
      if (other != axis) part(order_[other], begin, end);
  }
  const auto child = static_cast<std::uint32_t>(tree_->nodes.size());
  tree_->nodes[index].left = child;
  tree_->nodes.resize(tree_->nodes.size() + 2);
  divide(child, begin, middle, depth + 1);
  divide(child + 1, middle, end, depth + 1);
}

// Where the right side begins in the order along `axis`. Nodes of two and those too deep are halved.
std::size_t SweepBuilder::split(std::size_t begin, std::size_t end, std::uint32_t depth, std::size_t& axis) {
  std::size_t best = begin + (end - begin) / 2;
  if (end - begin == 2 || must_halve(end - begin, depth)) return best;
  std::int64_t best_cost = std::numeric_limits<std::int64_t>::max();
  for (std::size_t a = 0; a < 3; ++a) {
    const std::uint32_t* order = order_[a].data();
    PackedBox box;
    for (std::size_t i = end - 1; i > begin; --i) {
      box.add(boxes_[order[i]]);
      right_cost_[i] = box.half_area() * static_cast<std::int64_t>(end - i);
    }
    box = {};
    for (std::size_t i = begin + 1; i < end; ++i) {
      box.add(boxes_[order[i - 1]]);
      const std::int64_t cost = box.half_area() * static_cast<std::int64_t>(i - begin) + right_cost_[i];
      if (cost < best_cost) {
        best_cost = cost;
        best = i;
        axis = a;
      }
    }
  }
  return best;
}

void SweepBuilder::part(std::vector<std::uint32_t>& order, std::size_t begin, std::size_t end) {
  std::size_t left = begin;
  std::size_t right = 0;
  for (std::size_t i = begin; i < end; ++i) {
    const std::uint32_t reference = order[i];
    const std::size_t goes_left = goes_left_[reference];
    order[left] = reference;
    scratch_[right] = reference;
    left += goes_left;
    right += 1 - goes_left;
  }
  std::copy_n(scratch_.begin(), right, order.begin() + static_cast<std::ptrdiff_t>(left));
}

BinaryTree build_sweep_sah(std::span<const BvhReference> references) {
  ZC_CHECK(!references.empty());
  std::vector<PackedBox> packed;
  packed.reserve(references.size());
  for (const BvhReference& r : references) packed.emplace_back(r);
  BinaryTree tree;
  tree.nodes.reserve(2 * references.size());
  tree.references.reserve(references.size());
  tree.nodes.emplace_back();
  SweepBuilder().grow(tree, 0, packed, 1);
  return tree;
}

}  // namespace zc
