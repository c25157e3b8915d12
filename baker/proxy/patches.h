// SPDX-License-Identifier: GPL-3.0-or-later
// Patches: faces of one material that hang together by edges. Units: steps. Thread-safe: no state. Deterministic.
#pragma once

#include "baker/scene/lattice_mesh.h"

namespace zc {

// Gives patches whose box diagonal is below `size` the material that most of their border touches, larger patches only:
// a window too small to matter becomes wall, instead of a wall that becomes window.
void absorb_small_patches(LatticeMesh& mesh, double size);

}  // namespace zc
