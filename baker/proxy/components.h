// SPDX-License-Identifier: GPL-3.0-or-later
// Drops connected parts of a mesh that are too small to matter at a coarse level, and stands in for what got lost.
// Ground is never dropped, and the largest part always stays. Thread-safe: no state.
#pragma once

#include <cstddef>

#include "baker/scene/lattice_mesh.h"

namespace zc {

// Parts whose box diagonal is below `diagonal` steps, except the largest in each square of four diagonals; stops once
// no more than target_faces are left, and never falls below half of that.
void drop_small_components(LatticeMesh& mesh, double diagonal, std::size_t target_faces);

// Smallest surface first, until at most target_faces are left or nothing but ground.
void drop_components_to(LatticeMesh& mesh, std::size_t target_faces);

// Puts something small in the place of faces of `source` that `mesh` has lost altogether, the farthest from what is
// left first, until none is farther than `enough` steps or `budget` faces are spent: a closed body within the box of a
// part that is gone, else the face itself.
void add_stand_ins(const LatticeMesh& source, double enough, std::size_t budget, LatticeMesh& mesh);

}  // namespace zc
