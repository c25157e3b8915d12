// SPDX-License-Identifier: GPL-3.0-or-later
// A k-d tree of lattice points that finds those along a segment. (CGAL's Kd_tree answers boxes and balls; the box of a
// long diagonal edge contains half a city.) Units: steps. Thread-safe once built. Deterministic.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "baker/scene/lattice_mesh.h"

namespace zc {

class PointTree {
 public:
  // Borrows `points`; `indices`: those in the tree.
  PointTree(const std::vector<LatticePoint>& points, std::vector<std::uint32_t> indices);

  // Calls visit(index) for every point that may lie within a step of the segment, and some others near it.
  template <class Visit>
  void visit_near(const LatticePoint& a, const LatticePoint& b, const Visit& visit) const {
    std::vector<std::uint32_t> stack;
    if (!nodes_.empty()) stack.push_back(0);
    while (!stack.empty()) {
      const Node& node = nodes_[stack.back()];
      stack.pop_back();
      if (!intersects(node.box, a, b)) continue;
      if (node.left != 0) {
        stack.push_back(node.left + 1);
        stack.push_back(node.left);
        continue;
      }
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) visit(indices_[i]);
    }
  }

 private:
  struct Node {
    LatticeBox box;
    std::uint32_t left = 0;  // right follows; 0: a leaf
    std::uint32_t first = 0;
    std::uint32_t count = 0;
  };

  // Conservative: the box grown by a step.
  static bool intersects(const LatticeBox& box, const LatticePoint& a, const LatticePoint& b);

  std::vector<std::uint32_t> indices_;
  std::vector<Node> nodes_;
};

}  // namespace zc
