// SPDX-License-Identifier: GPL-3.0-or-later
// Joins open edges that the lattice tore apart: points that were equal but for rounding may snap to neighbouring
// lattice points. Units: steps. Thread-safe: no state. Deterministic.
#pragma once

#include <cstdint>

#include "baker/repair/mesh_part.h"

namespace zc {

struct StitchCounts {
  std::uint64_t joined = 0;  // edges
  double moved = 0;          // largest distance of a vertex, at most the diagonal of a step
};

// Two open edges of different faces become one when their ends are at most one step apart along every axis. May leave
// faces without area.
StitchCounts stitch_open_edges(MeshPart& part);

}  // namespace zc
