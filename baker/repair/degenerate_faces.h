// SPDX-License-Identifier: GPL-3.0-or-later
// Faces that add nothing: without area, or of the same three vertices as an earlier one. Thread-safe: no state.
#pragma once

#include <cstdint>

#include "baker/repair/mesh_part.h"

namespace zc {

struct DegenerateFaceCounts {
  std::uint64_t flat = 0;
  std::uint64_t repeated = 0;
  std::uint64_t back_to_back = 0;  // turned copies in one object: rays hit either side of what stays
};

// Of equal faces the first stays. Turned copies that belong to two objects both stay.
DegenerateFaceCounts drop_degenerate_faces(MeshPart& part);

}  // namespace zc
