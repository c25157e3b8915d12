// SPDX-License-Identifier: Apache-2.0
// What a host says of a frame: its camera, its light and the images that it has drawn.
// Units: metres relative to a lattice point next to the eye, so that floats near it are exact; radiance on one scale of
// the host's choice. Borrows the images, which stay as they are until the frame's commands were executed.
#pragma once

#include <vulkan/vulkan.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>

namespace zc {

struct FrameCamera {
  std::array<std::int32_t, 3> lattice = {};     // lattice point that the frame is relative to
  double step_m = 1.0 / 256;                    // lattice step
  glm::vec3 eye = {};                           // metres from that point
  glm::vec3 right = {}, up = {}, forward = {};  // orthonormal
  float fov_y_deg = 60;
  float near_m = 0.1F;         // of the depth buffer: depth is near_m over the distance along `forward`
  float ray_length_m = 20000;  // no ray needs to go further
};

// Puts the eye at a position of the world's CRS (metres). anchor, step_m: of the world's index.
inline void place_eye(FrameCamera& camera, const glm::dvec3& eye_m, const std::array<std::int64_t, 3>& anchor,
                      double step_m) {
  camera.step_m = step_m;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const double lattice = eye_m[axis] / step_m - static_cast<double>(anchor[i]);
    camera.lattice[i] = static_cast<std::int32_t>(std::llround(lattice));
    camera.eye[axis] = static_cast<float>((lattice - camera.lattice[i]) * step_m);
  }
}

struct FrameSun {
  glm::vec3 direction = {0, 0, 1};  // unit, towards the sun
  glm::vec3 radiance = {1.75F, 1.58F, 1.32F};
  // The pages were baked for this sun: they say what it lights, and no shadow ray is traced there.
  bool is_baked = false;
};

// Images are of the size that Reflections was created with, and in SHADER_READ_ONLY_OPTIMAL; their writes have been
// made visible to compute shaders. shaders/adapter/load_surface.glsl says what their texels contain.
struct HostFrame {
  FrameCamera camera;
  FrameCamera previous;        // of the frame before
  bool history_valid = false;  // `previous` and `motion` can be trusted: no camera cut, no resize
  FrameSun sun;
  VkImageView depth = VK_NULL_HANDLE;       // a depth or R32_SFLOAT: reversed Z, 0 is the sky
  VkImageView surface = VK_NULL_HANDLE;     // R32G32B32A32_UINT: geometric and shading normal, material
  VkImageView irradiance = VK_NULL_HANDLE;  // rgb: diffuse light on the surface before its colour; of the sky, radiance
  VkImageView motion = VK_NULL_HANDLE;      // rg: pixels since the frame before; may be null
};

}  // namespace zc
