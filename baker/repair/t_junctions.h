// SPDX-License-Identifier: GPL-3.0-or-later
// Inserts vertices of open edges into the open edges that they lie on, so that both sides of a border have the same
// vertices and no ray slips between. Units: steps. Thread-safe: no state. Deterministic at any thread count.
#pragma once

#include <cstdint>

#include "baker/repair/mesh_part.h"

namespace zc {

struct TJunctionCounts {
  std::uint64_t repaired = 0;  // vertices inserted into an edge
  std::uint64_t left = 0;      // where a part would have grown beyond twice its faces
  double moved = 0;            // largest distance of such a vertex from its edge, at most half a step
};

// A vertex lies on an edge within half a step of it when one of its own open edges runs along it, too.
TJunctionCounts repair_t_junctions(MeshPart& part);

}  // namespace zc
