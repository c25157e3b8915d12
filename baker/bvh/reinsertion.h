// SPDX-License-Identifier: GPL-3.0-or-later
// Improves a binary BVH by taking subtrees out and putting them back where they cost least. A pass takes the nodes of
// largest area in turn; each is searched a place by branch and bound and moved there at once when the sum of the inner
// nodes' areas falls. So the cost by the surface area heuristic never rises, and every reference stays.
// Sources: Bittner, Hapala & Havran 2013, "Fast insertion-based optimization of bounding volume hierarchies", for the
// moves; Meister & Bittner 2018, "Parallel reinsertion for bounding volume hierarchy optimization", section 3, for the
// search that starts where the node is, and for doing a part of the nodes in a pass.
// A pass that would make the tree deeper than kBinaryDepthMax is left out. Deterministic. Thread-safe: no state.
#pragma once

#include "baker/bvh/binary_tree.h"

namespace zc {

struct ReinsertionOptions {
  std::uint32_t passes = 2;
  float batch = 0.2F;  // part of the nodes that a pass takes
};

void optimize_by_reinsertion(BinaryTree& tree, const ReinsertionOptions& options);

}  // namespace zc
