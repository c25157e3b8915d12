// SPDX-License-Identifier: GPL-3.0-or-later
// Object splits by the surface area heuristic from the top down: see object_split.h.
// The depth stays below kBinaryDepthMax: deeper, and where all centres agree, the references are halved.
// Deterministic. Thread-safe: no state.
#pragma once

#include <span>

#include "baker/bvh/binary_tree.h"

namespace zc {

inline constexpr std::uint32_t kBinaryDepthMax = 45;

// Whether a node with so many references, so many nodes below the root (itself 1), must be halved from here on for its
// subtree to end within kBinaryDepthMax.
bool must_halve(std::size_t references, std::uint32_t depth);

BinaryTree build_binned_sah(std::span<const BvhReference> references);  // at least one

}  // namespace zc
