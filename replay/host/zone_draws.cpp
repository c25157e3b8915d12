// SPDX-License-Identifier: Apache-2.0
#include "replay/host/zone_draws.h"

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace zc {

bool outside_view(const FrameCamera& camera, double aspect, const NodeRecord& node) {
  const double tan_y = std::tan(glm::radians(static_cast<double>(camera.fov_y_deg)) / 2);
  const glm::dvec3 right(camera.right);
  const glm::dvec3 up(camera.up);
  const glm::dvec3 forward(camera.forward);
  const std::array<glm::dvec3, 5> inward = {forward, forward * (tan_y * aspect) + right,
                                            forward * (tan_y * aspect) - right, forward * tan_y + up,
                                            forward * tan_y - up};
  for (const glm::dvec3& plane : inward) {
    glm::dvec3 corner{};  // the one furthest along the plane's normal
    for (int axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<std::size_t>(axis);
      const double lattice = plane[axis] > 0 ? node.bounds_max[i] : node.bounds_min[i];
      corner[axis] = (lattice - camera.lattice[i]) * camera.step_m;
    }
    if (glm::dot(corner - glm::dvec3(camera.eye), plane) < 0) return true;
  }
  return false;
}

std::vector<ZoneDraw> zone_draws(const ZoneSet& zones, const IndexView& index, const FrameCamera& camera, double aspect,
                                 bool cull) {
  std::vector<ZoneDraw> draws;
  for (std::uint32_t slot = 0; slot < zones.zone_count(); ++slot) {
    const NodeRecord& node = index.nodes[zones.shown()[slot].node];
    if (cull && outside_view(camera, aspect, node)) continue;
    draws.push_back({slot, zones.triangle_count(slot), node.bvh_node_count});
  }
  return draws;
}

}  // namespace zc
