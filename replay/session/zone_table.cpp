// SPDX-License-Identifier: Apache-2.0
#include "replay/session/zone_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
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

Status ZoneTable::update(const View& view) {
  const WorldIndex& index = streamer_.index();
  std::vector<gpu::ZoneEntry> entries;
  for (const std::uint32_t id : streamer_.rendered_cut()) {
    const NodeRecord& node = index.nodes[id];
    const bool refinable = node.child_count > 0 && !index.nodes[node.first_child].is_detail();
    const bool coarse = refinable && weighted_error(index, id, std::span(&view, 1)) > tolerance_;
    entries.push_back({node.origin[0], node.origin[1], node.origin[2], node.step_shift,
                       static_cast<std::uint32_t>(streamer_.page_offset_words(id)), id, node.error_max_m,
                       coarse ? gpu::kZoneCoarse : 0});
  }
  std::ranges::sort(entries, {}, &gpu::ZoneEntry::page_word);
  const bool same = entries.size() == entries_.size() &&
                    std::memcmp(entries.data(), entries_.data(), entries.size() * sizeof(gpu::ZoneEntry)) == 0;
  if (same) return {};
  entries_ = std::move(entries);
  return zones_.set_zones(entries_);
}

std::vector<ZoneDraw> ZoneTable::draws(const FrameCamera& camera, double aspect, bool cull) const {
  std::vector<ZoneDraw> draws;
  for (std::uint32_t slot = 0; slot < entries_.size(); ++slot) {
    const NodeRecord& node = streamer_.index().nodes[entries_[slot].node];
    if (cull && outside_view(camera, aspect, node)) continue;
    draws.push_back({slot, zones_.triangle_count(slot), node.bvh_node_count});
  }
  return draws;
}

}  // namespace zc
