// SPDX-License-Identifier: GPL-3.0-or-later
// Object splits by the surface area heuristic with every division along every axis tried at every node: references are
// sorted once along each axis, and each split keeps the three orders.
// Source: Wald & Havran 2006, "On building fast kd-trees for ray tracing, and on doing that in O(N log N)",
// section 4.3, for boxes. The depth stays below kBinaryDepthMax, as in binned_sah.h. Deterministic. Thread-safe: no
// state beyond the builder's.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "baker/bvh/binary_tree.h"
#include "baker/bvh/packed_box.h"

namespace zc {

// Grows subtrees; keeps its memory for the next.
class SweepBuilder {
 public:
  // Over at least one reference; their node is there already, `depth` nodes from the root (itself 1). Nodes and
  // references are appended.
  void grow(BinaryTree& tree, std::uint32_t node, std::span<const PackedBox> references, std::uint32_t depth);

 private:
  void sort(std::span<const PackedBox> references);
  void divide(std::uint32_t index, std::size_t begin, std::size_t end, std::uint32_t depth);
  std::size_t split(std::size_t begin, std::size_t end, std::uint32_t depth, std::size_t& axis);
  void part(std::vector<std::uint32_t>& order, std::size_t begin, std::size_t end);

  BinaryTree* tree_ = nullptr;
  std::span<const PackedBox> boxes_;
  std::array<std::vector<std::uint32_t>, 3> order_;
  std::vector<std::uint64_t> keys_;
  std::vector<std::int64_t> right_cost_;
  std::vector<std::uint8_t> goes_left_;
  std::vector<std::uint32_t> scratch_;
};

BinaryTree build_sweep_sah(std::span<const BvhReference> references);  // at least one

}  // namespace zc
