// SPDX-License-Identifier: GPL-3.0-or-later
// Exact predicates on lattice points, in integers. Units: steps. Thread-safe: no state.
#pragma once

#include <array>
#include <cstdint>

#include "baker/scene/lattice_mesh.h"

namespace zc {

using LatticeVector = std::array<std::int64_t, 3>;

LatticeVector difference(const LatticePoint& to, const LatticePoint& from);
std::int64_t dot(const LatticeVector& a, const LatticeVector& b);  // of differences: exact
LatticeVector cross(const LatticeVector& a, const LatticeVector& b);

// Whether p lies before no end of the edge and within half a step of it; a != b.
bool near_inside(const LatticePoint& p, const LatticePoint& a, const LatticePoint& b);

double distance_to_line(const LatticePoint& p, const LatticePoint& a, const LatticePoint& b);

}  // namespace zc
