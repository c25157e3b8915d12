// SPDX-License-Identifier: Apache-2.0
#include "runtime/frame_data.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace zc {
namespace {

gpu::vec4 to_vec4(const glm::vec3& v, float w = 0) { return {v.x, v.y, v.z, w}; }

}  // namespace

void fill_frame_data(const FrameCamera& camera, const FrameSun& sun, std::uint32_t width, std::uint32_t height,
                     gpu::FrameData& out) {
  const float tan_y = std::tan(glm::radians(camera.fov_y_deg) * 0.5F);
  const float tan_x = tan_y * static_cast<float>(width) / static_cast<float>(height);
  // Rows of the projection: x right, y down (Vulkan), reversed Z with the far plane at infinity; w = view distance.
  const glm::vec3 x = camera.right / tan_x;
  const glm::vec3 y = -camera.up / tan_y;
  const glm::vec3& z = camera.forward;
  for (int column = 0; column < 3; ++column) out.view_projection.column[column] = {x[column], y[column], 0, z[column]};
  out.view_projection.column[3] = {-glm::dot(x, camera.eye), -glm::dot(y, camera.eye), camera.near_m,
                                   -glm::dot(z, camera.eye)};
  out.eye = to_vec4(camera.eye);
  out.right = to_vec4(camera.right);
  out.up = to_vec4(camera.up);
  out.forward = to_vec4(camera.forward);
  out.sun_direction = to_vec4(sun.direction);
  out.sun_radiance = to_vec4(sun.radiance);
  out.camera_lattice = {camera.lattice[0], camera.lattice[1], camera.lattice[2], 0};
  out.near_m = camera.near_m;
  out.tan_half_fov_x = tan_x;
  out.tan_half_fov_y = tan_y;
  out.ray_length_m = camera.ray_length_m;
  out.step_m = static_cast<float>(camera.step_m);
  out.sun_is_baked = sun.is_baked ? 1 : 0;
  out.width = width;
  out.height = height;
}

void fill_frame_data(const ZoneSet& zones, gpu::FrameData& out) {
  out.root_word = zones.root_word();
  out.zone_count = zones.zone_count();
  out.end_word = zones.end_word();
}

void bind_zones(const ZoneSet& zones, BindingTable& table) {
  table.set_buffer(gpu::kBindPool, zones.pool().handle());
  table.set_buffer(gpu::kBindPool4, zones.pool().handle());
  table.set_texels(gpu::kBindPoolTexels, zones.texels().handle());
  table.set_texels(gpu::kBindPoolTexels4, zones.texels4().handle());
  table.set_buffer(gpu::kBindZones, zones.zones().handle());
}

}  // namespace zc
