// SPDX-License-Identifier: GPL-3.0-or-later
// Drops faces thinner than half a step: a corner lies on the opposite side, so that what touches its sides can touch
// without it. Only where another face contains that side, or both others: no line vanishes. Units: steps.
// Thread-safe: no state.
#pragma once

#include <cstdint>

#include "baker/repair/mesh_part.h"

namespace zc {

struct SliverCounts {
  std::uint64_t dropped = 0;
  double moved = 0;  // largest distance from a dropped face to what stays
};

// Faces must not be flat. Leaves T-junctions.
SliverCounts drop_slivers(MeshPart& part);

}  // namespace zc
