// SPDX-License-Identifier: GPL-3.0-or-later
// Turns faces so that neighbours face the same side: closed parts outwards, ground upwards, other open parts the way
// most of their area did. Own code, as CGAL's orient_polygon_soup tears vertices apart at edges of three and more faces
// and gives no say about which way a part turns; all sums here are exact integers. Thread-safe: no state.
// Deterministic.
#pragma once

#include <cstdint>

#include "baker/repair/mesh_part.h"

namespace zc {

struct OrientCounts {
  std::uint64_t turned = 0;
  std::uint64_t one_sided_parts = 0;  // like a Möbius strip: some neighbours still disagree
};

// Parts hang together by edges of exactly two faces. Faces must not be flat.
OrientCounts orient_faces(MeshPart& part);

}  // namespace zc
