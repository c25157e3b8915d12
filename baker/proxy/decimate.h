// SPDX-License-Identifier: GPL-3.0-or-later
// Half-edge collapse of a triangle soup with OpenMesh: vertices of the result are vertices of the input, so they stay
// on the lattice. Non-manifold input is cut into manifold fans first; nothing is lost.
// Sources: Garland & Heckbert 1997 (quadrics as priority); Klein, Liebich & Straßer 1996 (one-sided Hausdorff bound).
// Units: steps. Thread-safe: no state.
#pragma once

#include <cstddef>
#include <vector>

#include "baker/scene/lattice_mesh.h"

namespace zc {

struct DecimateOptions {
  double tolerance = 0;               // how far removed vertices and open borders may lie from the result
  std::size_t target_faces = 0;       // stop here; 0: collapse all that the tolerance allows
  double normal_turn_deg = 45;        // largest turn of a face by one collapse
  bool keep_material_borders = true;  // to within a quarter of the tolerance
};

// locked: per vertex of `mesh`; those stay.
LatticeMesh decimate(LatticeMesh mesh, std::vector<bool> locked, const DecimateOptions& options);

}  // namespace zc
