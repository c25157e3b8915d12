// SPDX-License-Identifier: GPL-3.0-or-later
// Collapses a binary BVH to nodes of at most eight children at least expected cost, choosing the leaves' sizes as well.
// Source: Ylitie, Karras & Laine 2017, "Efficient incoherent ray traversal on GPUs through compressed wide BVHs",
// section 3.2 (the dynamic programme) and 3.1 (slots by octant). Deterministic. Thread-safe: no state.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "baker/bvh/binary_tree.h"
#include "shaders/shared/page.h"

namespace zc {

struct CollapseOptions {
  std::uint32_t width = gpu::kNodeWidth;                  // 2 to 8
  std::uint32_t leaf_triangles = gpu::kLeafMaxTriangles;  // at most, of one leaf
  float node_cost = 1.0F;                                 // of visiting a node, against …
  float triangle_cost = 0.4F;                             // … testing a triangle
  float node_place_cost = 1;                              // of a node's bytes: in visits of the root, per reference
  bool by_levels = false;  // three binary levels a node, whatever it costs: bounds the depth
};

struct WideChild {
  enum class Kind : std::uint8_t { kNone, kNode, kLeaf };
  Kind kind = Kind::kNone;
  BvhBox box;
  std::uint32_t first = 0;  // node: its index; leaf: its first reference
  std::uint32_t count = 0;  // leaf: references
};

// By slot: `slot ^ octant` orders the children roughly front to back for rays of an octant.
struct WideNode {
  std::array<WideChild, gpu::kNodeWidth> slots;
};

// Node 0 is the root. The child nodes of one node are contiguous, in the order of their slots, and lie behind it; the
// references of one node's leaves are contiguous as well, in the same order.
struct WideTree {
  std::vector<WideNode> nodes;
  std::vector<BvhReference> references;
  std::uint32_t depth = 0;  // nodes on the longest path
};

WideTree collapse(const BinaryTree& tree, const CollapseOptions& options);

}  // namespace zc
