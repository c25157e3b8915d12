// SPDX-License-Identifier: GPL-3.0-or-later
// Vertex collapse of a triangle soup within a tolerance, whatever its topology: vertices join their neighbours as long
// as every point of the new surface stays within the tolerance of the reference's surface of the same appearance, and
// every sample of the reference within it of the new surface. Vertices of the result are vertices of the input, so they
// stay on the lattice. What is closed stays closed: no collapse opens an edge, so that bars and poles do not end as
// sheets. Sources: Popović & Hoppe 1997 (collapse of simplicial complexes), Garland & Heckbert 1997 (quadrics as
// priority), Cohen et al. 1996 (envelopes). Units: steps. Thread-safe: no state. Deterministic.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "baker/distance/work_budget.h"
#include "baker/scene/lattice_mesh.h"

namespace zc {

struct CollapseOptions {
  double tolerance = 0;  // two-sided, of surfaces and of borders between appearances
  double normal_turn_deg =
      2;  // largest turn of a face from where it began; faces narrower than the tolerance turn freely
  std::size_t target_faces = 0;  // stop here; 0: collapse all that the tolerance allows
};

struct Collapsed {
  LatticeMesh mesh;
  Work work;  // is spent where more of it would have left fewer faces
};

// locked: per vertex of `mesh`; those stay, and so do edges between them. appearances: per material. The result is
// within the tolerance of `mesh`, two-sided; the input itself where nothing simpler is.
Collapsed collapse_vertices(const LatticeMesh& mesh, const std::vector<bool>& locked,
                            std::span<const std::uint16_t> appearances, const CollapseOptions& options);

}  // namespace zc
