// SPDX-License-Identifier: GPL-3.0-or-later
// Dividing references by a plane that cuts those it intersects: binned spatial splits.
// Everything is exact or rounded outwards to the lattice: a piece's box contains all of the triangle that lies in the
// piece. Quotients are taken in doubles: numerators and denominators are integers below 2^33, so that a quotient that
// is no integer differs from every integer by more than its rounding error, and floor and ceiling come out exactly.
// Source: Stich, Friedrich & Dietrich 2009, "Spatial splits in bounding volume hierarchies", sections 3.2 and 4.
// Deterministic. Thread-safe: no state.
#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "baker/bvh/packed_box.h"

namespace zc {

// Bounds of what `triangle` has between two planes across `axis`, both included; empty where it has nothing there.
PackedBox slab_box(const BvhTriangle& triangle, std::size_t axis, std::uint32_t low, std::uint32_t high);

struct SpatialSplit {
  std::int64_t cost = std::numeric_limits<std::int64_t>::max();  // half areas times references
  std::size_t left = 0;
  std::size_t right = 0;  // references; those that the plane cuts count on both sides
  PackedBox left_box;
  PackedBox right_box;
  std::size_t axis = 0;
  std::uint32_t plane = 0;
};

// The best plane among a few across the widest axis of `box`, which bounds the references; its cost is greatest where
// there is none. (With planes across all axes rays cost less by less than one part in a hundred, building twice as
// much.)
SpatialSplit find_spatial_split(std::span<const PackedBox> references, const PackedBox& box,
                                std::span<const BvhTriangle> triangles);

enum class Side : std::uint8_t { kLeft, kRight, kBoth };
inline Side side_of(const PackedBox& reference, const SpatialSplit& split) {
  if (reference.min(split.axis) >= split.plane) return Side::kRight;
  return reference.max(split.axis) <= split.plane ? Side::kLeft : Side::kBoth;
}

}  // namespace zc
