// SPDX-License-Identifier: GPL-3.0-or-later
// Object splits by the surface area heuristic: binned (Wald 2007, "On fast construction of SAH-based bounding volume
// hierarchies") where a node has many references, a full sweep where it has few.
// The depth stays below kBinaryDepthMax: deeper, and where all centres agree, the references are halved.
// Deterministic. Thread-safe: no state.
#pragma once

#include <vector>

#include "baker/bvh/binary_tree.h"

namespace zc {

inline constexpr std::uint32_t kBinaryDepthMax = 48;

BinaryTree build_binned_sah(std::vector<BvhReference> references);  // at least one

}  // namespace zc
