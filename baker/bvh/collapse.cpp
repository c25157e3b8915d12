// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/bvh/collapse.h"

#include <limits>

#include "base/check.h"
#include "shaders/shared/page_node.h"

namespace zc {
namespace {

constexpr std::uint32_t kRootsLimit = gpu::kNodeWidth - 1;

NodeBox wide_box(const BvhBox& b) { return {{b.min[0], b.min[1], b.min[2]}, {b.max[0], b.max[1], b.max[2]}}; }

class Collapse {
 public:
  Collapse(const BinaryTree& tree, const CollapseOptions& options)
      : tree_(tree),
        options_(options),
        node_place_(options.node_place_cost * static_cast<float>(tree.nodes[0].box.half_area()) /
                    static_cast<float>(tree.references.size())),
        best_(tree.nodes.size()) {}

  WideTree run() {
    for (std::size_t i = tree_.nodes.size(); i-- > 0;) weigh(static_cast<std::uint32_t>(i));  // children lie behind
    out_.nodes.reserve(tree_.nodes.size() / 4 + 1);
    out_.references.reserve(tree_.references.size());
    out_.nodes.emplace_back();
    emit(0, 0, 1);
    return std::move(out_);
  }

 private:
  // For one binary node: the least cost of its subtree as a forest of at most i + 1 trees, and how it comes about.
  struct Best {
    std::array<float, kRootsLimit> cost;
    std::array<std::uint8_t, kRootsLimit> left_roots;  // of the left child; 0: as for one root less
    std::uint8_t node_left_roots = 0;                  // likewise when it becomes a node of its own
    bool leaf = false;                                 // whether one tree is a leaf
    std::uint32_t count = 0;                           // references
  };

  void weigh(std::uint32_t index) {
    const BinaryNode& node = tree_.nodes[index];
    Best& best = best_[index];
    const auto area = static_cast<float>(node.box.half_area());
    if (node.is_leaf()) {
      best.count = 1;
      best.leaf = true;
      best.cost.fill(area * options_.triangle_cost);
      best.left_roots.fill(0);
      return;
    }
    const Best& left = best_[node.left];
    const Best& right = best_[node.left + 1];
    best.count = left.count + right.count;
    const auto distribute = [&](std::uint32_t roots, std::uint8_t& left_roots) {
      float least = std::numeric_limits<float>::infinity();
      for (std::uint32_t k = 1; k < roots; ++k) {
        const float cost = left.cost[std::min(k, kRootsLimit) - 1] + right.cost[std::min(roots - k, kRootsLimit) - 1];
        if (cost < least) {
          least = cost;
          left_roots = static_cast<std::uint8_t>(k);
        }
      }
      return least;
    };
    const float as_node = distribute(options_.width, best.node_left_roots) + area * options_.node_cost + node_place_;
    const float as_leaf = best.count <= options_.leaf_triangles
                              ? area * options_.triangle_cost * static_cast<float>(best.count)
                              : std::numeric_limits<float>::infinity();
    best.leaf = as_leaf <= as_node;
    best.cost[0] = std::min(as_leaf, as_node);
    best.left_roots[0] = 0;
    for (std::uint32_t roots = 2; roots <= kRootsLimit; ++roots) {
      std::uint8_t left_roots = 0;
      const float cost =
          roots < options_.width ? distribute(roots, left_roots) : std::numeric_limits<float>::infinity();
      best.cost[roots - 1] = std::min(cost, best.cost[roots - 2]);
      best.left_roots[roots - 1] = cost < best.cost[roots - 2] ? left_roots : std::uint8_t{0};
    }
  }

  // The binary nodes that become the children of a wide node.
  void find_children(std::uint32_t index, std::uint32_t roots, std::vector<std::uint32_t>& out) const {
    const Best& best = best_[index];
    while (roots > 1 && best.left_roots[roots - 1] == 0) --roots;
    if (roots <= 1) {
      out.push_back(index);
      return;
    }
    const std::uint32_t k = best.left_roots[roots - 1];
    find_children(tree_.nodes[index].left, std::min(k, kRootsLimit), out);
    find_children(tree_.nodes[index].left + 1, std::min(roots - k, kRootsLimit), out);
  }

  void find_by_levels(std::uint32_t index, std::uint32_t levels, std::vector<std::uint32_t>& out) const {
    if (levels == 0 || best_[index].leaf) {
      out.push_back(index);
      return;
    }
    find_by_levels(tree_.nodes[index].left, levels - 1, out);
    find_by_levels(tree_.nodes[index].left + 1, levels - 1, out);
  }

  void append_references(std::uint32_t index) {
    const BinaryNode& node = tree_.nodes[index];
    if (node.is_leaf()) {
      out_.references.push_back(tree_.references[node.reference]);
    } else {
      append_references(node.left);
      append_references(node.left + 1);
    }
  }

  // Large leaves become nodes where a node would have more triangles than it can number.
  void keep_within_node(std::span<const std::uint32_t> children) {
    for (;;) {
      std::uint32_t triangles = 0;
      std::uint32_t largest = children[0];
      for (const std::uint32_t child : children) {
        if (!best_[child].leaf) continue;
        triangles += best_[child].count;
        if (!best_[largest].leaf || best_[child].count > best_[largest].count) largest = child;
      }
      if (triangles <= gpu::kNodeMaxTriangles) return;
      best_[largest].leaf = false;
    }
  }

  // Pieces of one triangle that are in one leaf again, which begins at `first`, become one.
  void merge_pieces(std::size_t first) {
    std::size_t end = first;
    for (std::size_t i = first; i < out_.references.size(); ++i) {
      const BvhReference reference = out_.references[i];
      std::size_t same = first;
      while (same < end && out_.references[same].triangle != reference.triangle) ++same;
      if (same < end) {
        out_.references[same].box.add(reference.box);
      } else {
        out_.references[end++] = reference;
      }
    }
    out_.references.resize(end);
  }

  void emit(std::uint32_t wide, std::uint32_t index, std::uint32_t depth) {
    out_.depth = std::max(out_.depth, depth);
    std::vector<std::uint32_t> children;
    const BinaryNode& node = tree_.nodes[index];
    if (best_[index].leaf) {
      children.push_back(index);  // only at the root: a tree that is one leaf
    } else if (options_.by_levels) {
      find_by_levels(index, 3, children);
    } else {
      const std::uint32_t k = best_[index].node_left_roots;
      find_children(node.left, std::min(k, kRootsLimit), children);
      find_children(node.left + 1, std::min(options_.width - k, kRootsLimit), children);
    }
    keep_within_node(children);
    std::array<NodeBox, gpu::kNodeWidth> boxes;
    for (std::size_t i = 0; i < children.size(); ++i) boxes[i] = wide_box(tree_.nodes[children[i]].box);
    const auto child_of_slot = assign_slots(std::span(boxes).first(children.size()));

    const auto first_node = static_cast<std::uint32_t>(out_.nodes.size());
    std::uint32_t nodes = 0;
    for (std::size_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
      if (child_of_slot[slot] < 0) continue;
      const std::uint32_t binary = children[static_cast<std::size_t>(child_of_slot[slot])];
      WideChild& child = out_.nodes[wide].slots[slot];
      child.box = tree_.nodes[binary].box;
      if (best_[binary].leaf) {
        child.kind = WideChild::Kind::kLeaf;
        child.first = static_cast<std::uint32_t>(out_.references.size());
        append_references(binary);
        merge_pieces(child.first);
        child.count = static_cast<std::uint32_t>(out_.references.size()) - child.first;
      } else {
        child.kind = WideChild::Kind::kNode;
        child.first = first_node + nodes++;
      }
    }
    out_.nodes.resize(out_.nodes.size() + nodes);
    std::uint32_t next = first_node;
    for (std::size_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
      if (out_.nodes[wide].slots[slot].kind != WideChild::Kind::kNode) continue;
      emit(next++, children[static_cast<std::size_t>(child_of_slot[slot])], depth + 1);
    }
  }

  const BinaryTree& tree_;
  CollapseOptions options_;
  float node_place_;
  std::vector<Best> best_;
  WideTree out_;
};

}  // namespace

WideTree collapse(const BinaryTree& tree, const CollapseOptions& options) {
  ZC_CHECK(!tree.nodes.empty() && options.width >= 2 && options.width <= gpu::kNodeWidth);
  ZC_CHECK(options.leaf_triangles >= 1 && options.leaf_triangles <= gpu::kLeafMaxTriangles);
  return Collapse(tree, options).run();
}

}  // namespace zc
