// SPDX-License-Identifier: Apache-2.0
#include "replay/bench/engines/zone_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "base/check.h"

namespace zc::bench {

ZoneMesh weld_zone(const BenchScene& scene, const BenchZone& zone, NodeRecord& node) {
  using Point = std::array<std::int32_t, 3>;
  const auto corner = [&](std::uint32_t triangle, std::size_t k) {
    Point p;
    for (std::size_t axis = 0; axis < 3; ++axis)
      p[axis] = static_cast<std::int32_t>(
          std::lround(static_cast<double>(scene.triangles[triangle].v[3 * k + axis]) / scene.step_m));
    return p;
  };
  node.step_shift = zone.step_shift;
  node.bounds_min.fill(INT32_MAX);
  node.bounds_max.fill(INT32_MIN);
  for (std::uint32_t i = 0; i < zone.count; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Point p = corner(zone.first + i, k);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        node.bounds_min[axis] = std::min(node.bounds_min[axis], p[axis]);
        node.bounds_max[axis] = std::max(node.bounds_max[axis], p[axis]);
      }
    }
  }
  node.origin = node.bounds_min;
  ZoneMesh mesh;
  mesh.materials.resize(zone.count);
  mesh.triangles.resize(zone.count);
  std::map<Point, std::uint32_t> known;
  for (std::uint32_t i = 0; i < zone.count; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Point p = corner(zone.first + i, k);
      const auto [at, fresh] = known.try_emplace(p, static_cast<std::uint32_t>(mesh.vertices.size()));
      if (fresh) {
        std::array<std::uint16_t, 3> q;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const std::int32_t offset = (p[axis] - node.origin[axis]) >> node.step_shift;
          ZC_CHECK(offset >= 0 && offset <= 65535);
          q[axis] = static_cast<std::uint16_t>(offset);
        }
        mesh.vertices.push_back(q);
      }
      mesh.triangles[i][k] = at->second;
    }
  }
  node.triangle_count = zone.count;
  node.vertex_count = static_cast<std::uint32_t>(mesh.vertices.size());
  node.primitive_count = 1;
  return mesh;
}

}  // namespace zc::bench
