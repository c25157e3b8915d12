// SPDX-License-Identifier: GPL-3.0-or-later
// Vertex clustering on a grid: coarsens any soup, whatever its topology, where edge collapse is stuck.
// Source: Rossignac & Borrel 1993, with an existing vertex as each cluster's representative. Thread-safe: no state.
#pragma once

#include <cstdint>
#include <vector>

#include "baker/scene/lattice_mesh.h"

namespace zc {

// Joins all vertices in one cell of 2^cell_log2 steps, except locked ones (per vertex of `mesh`), and cleans.
LatticeMesh cluster_vertices(const LatticeMesh& mesh, const std::vector<bool>& locked, std::uint32_t cell_log2);

}  // namespace zc
