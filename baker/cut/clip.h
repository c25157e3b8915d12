// SPDX-License-Identifier: GPL-3.0-or-later
// Clips loose triangles against one cell border plane, exactly, and repairs the T-junctions that a deeper cut on one
// side of a border leaves on the other. Thread-safe: no state.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "baker/cut/cut.h"
#include "baker/scene/lattice_mesh.h"

namespace zc {

struct LooseFace {
  std::array<LatticePoint, 3> p;
  std::array<float, 3> moved = {};  // of each point: how far rounding took it off the face as it was, at most; steps
  float share = 1;                  // of the triangle that it is a piece of: each cut leaves half of it on either side
  std::uint16_t material = 0;
  bool ground = false;
};

// An edge along a border that was cut at `point`: the zone on the other side needs that vertex too.
struct EdgeSplit {
  LatticePoint a;  // a < b
  LatticePoint b;
  LatticePoint point;
  float moved = 0;

  auto operator<=>(const EdgeSplit&) const = default;
};

struct ClipResult {
  std::vector<LooseFace> low;
  std::vector<LooseFace> high;
};

// axis: 0 = x, 1 = y. Faces in the plane go low. Appends to `splits`.
ClipResult clip_faces(const std::vector<LooseFace>& faces, std::size_t axis, std::int32_t plane, const CellGrid& grid,
                      std::vector<EdgeSplit>& splits);

// Inserts the vertices of `splits` (sorted) into the edges of `faces`.
void apply_splits(std::vector<LooseFace>& faces, const std::vector<EdgeSplit>& splits);

}  // namespace zc
