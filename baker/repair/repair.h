// SPDX-License-Identifier: GPL-3.0-or-later
// Repairs a snapped scene before it is cut, object by object, all ground as one: drops faces that add nothing, stitches
// what the lattice tore, drops slivers, repairs T-junctions, turns faces to one side. Holes and self-intersections
// stay: nothing is invented. Of the whole city it needs the ground, whose parts share their edges, and the objects
// whose faces may repeat one another's. Fails when no face is left. Deterministic at any thread count.
#pragma once

#include <cstdint>
#include <vector>

#include "baker/repair/snap.h"
#include "baker/scene/scene.h"
#include "base/result.h"

namespace zc {

struct RepairReport {
  std::vector<ImportCount> counts;  // what was dropped or changed, by kind; none is 0
  std::uint64_t open_edges = 0;     // edges of one face alone that stay: the rims of sheets and of holes
  double border_error_m = 0;        // largest distance that a part of the surface moved
};

struct RepairedScene {
  SnappedScene scene;
  RepairReport report;
};

Result<RepairedScene> repair_scene(SnappedScene&& scene, BakeContext& context);

}  // namespace zc
