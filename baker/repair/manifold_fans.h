// SPDX-License-Identifier: GPL-3.0-or-later
// Splits the vertices of a triangle soup so that every edge has at most two faces of matching orientation and every
// vertex one fan: what a half-edge structure accepts. Thread-safe: no state.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "baker/scene/lattice_mesh.h"

namespace zc {

struct ManifoldFans {
  std::vector<std::uint32_t> source_vertex;             // per fan: the vertex of the input
  std::vector<std::array<std::uint32_t, 3>> face_fans;  // per face: its corners' fans
};

ManifoldFans split_into_fans(const LatticeMesh& mesh);

// Cuts what has more than `most` faces around one vertex into sectors of at most so many, each with a copy of that
// vertex behind the others. locked: per vertex, grows with them; set where sectors touch, so that nothing gapes.
void cut_wide_fans(LatticeMesh& mesh, std::size_t limit, std::vector<bool>& locked);

}  // namespace zc
