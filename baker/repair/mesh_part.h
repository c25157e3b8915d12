// SPDX-License-Identifier: GPL-3.0-or-later
// What the repair works on: one object, or all of the ground, with vertices of its own. Thread-safe: plain values.
#pragma once

#include <cstdint>
#include <vector>

#include "baker/scene/lattice_mesh.h"

namespace zc {

struct MeshPart {
  LatticeMesh mesh;                   // welded
  std::vector<std::uint32_t> object;  // of each face

  void erase_faces(const std::vector<bool>& drop);
};

}  // namespace zc
