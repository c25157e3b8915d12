// SPDX-License-Identifier: GPL-3.0-or-later
// A BVH with spatial splits: from the top down, a node is divided by its best object split or, where the two sides of
// that overlap much, by a plane that cuts references in two when that costs less. A reference that the plane cuts still
// goes to one side alone where that is cheaper ("unsplitting"). The number of references stays within (1 +
// max_duplication) times the triangles: what a node may add is shared out to its children by their references, and what
// the left one does not use is the right one's. The depth stays below kBinaryDepthMax, as in binned_sah.h. Source:
// Stich, Friedrich & Dietrich 2009, "Spatial splits in bounding volume hierarchies". Deterministic. Thread-safe: no
// state.
#pragma once

#include <span>

#include "baker/bvh/binary_tree.h"

namespace zc {

struct SbvhOptions {
  float max_duplication = 0.3F;  // references beyond the triangles, as a part of them
  float alpha = 1e-4F;           // overlap of the children, as a part of the root's area, from which planes are tried
  float reference_cost = 0;      // of one reference more, in tests of a triangle as large as the root, per triangle
};

// At least one triangle.
BinaryTree build_sbvh(std::span<const BvhTriangle> triangles, const SbvhOptions& options);

}  // namespace zc
