// SPDX-License-Identifier: GPL-3.0-or-later
// Cuts the textured triangles of a zone into charts: connected, nearly flat regions that hide nothing of themselves
// when they are seen along one lattice axis. Deterministic. Thread-safe: no state.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "streamer/world_format/bvh_page.h"

namespace zc {

struct Chart {
  std::uint32_t axis = 0;  // seen along it; the other two, in order, are the chart's u and v
  double facing = 1;       // sign of the normals along the axis
  std::vector<std::uint32_t> triangles;
  std::array<std::int32_t, 2> min = {};  // the zone's steps
  std::array<std::int32_t, 2> max = {};

  [[nodiscard]] int u() const { return axis == 0 ? 1 : 0; }
  [[nodiscard]] int v() const { return axis == 2 ? 1 : 2; }
};

// textured: per triangle of the mesh.
std::vector<Chart> cut_charts(const ZoneMesh& mesh, const std::vector<bool>& textured);

}  // namespace zc
