// SPDX-License-Identifier: GPL-3.0-or-later
// Triangles in pieces, each with a box of its own: long ones that lie across the axes would fill a tree with boxes that
// contain little of them. Source: Ernst & Greiner 2007, "Early split clipping". Units: steps. Deterministic.
// Thread-safe: no state.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "baker/distance/hausdorff_bound.h"
#include "baker/scene/lattice_mesh.h"

namespace zc {

struct TrianglePiece {
  TrianglePiece(const Corners& corners, std::uint32_t of);

  Corners corner;
  LatticeBox box;
  std::uint32_t triangle = 0;
  double waste = 0;  // half of the box's surface beyond what a triangle along the axes would need
};

double half_surface(const LatticeBox& box);

// Halves those that waste the most, at their longest side, until none wastes more than `bearable` or there are `limit`.
std::vector<TrianglePiece> pieces_of(std::size_t count, const std::function<Corners(std::size_t)>& triangle,
                                     double bearable, std::size_t limit);

}  // namespace zc
