// SPDX-License-Identifier: Apache-2.0
#include "replay/paths/frame_camera.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>

namespace zc {
namespace {

// Fails where the renderer's 32-bit lattice does not reach.
Status check_reach(const IndexView& index, const CameraSample& sample) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const double lattice = sample.eye[axis] / index.step_m() - static_cast<double>(index.header.anchor[i]);
    const double above = lattice - index.header.bounds_min[i];
    const double below = index.header.bounds_max[i] - lattice;
    if (!(std::abs(lattice) < 2e9 && std::abs(above) < 2e9 && std::abs(below) < 2e9))
      return Error{ErrorCode::kUnsupported, "the camera at " + std::to_string(sample.time_s) +
                                                " s lies too far from the world: do path and world share a CRS?"};
  }
  return {};
}

}  // namespace

Result<FrameCamera> make_camera(const IndexView& index, const CameraSample& sample) {
  ZC_TRY(check_reach(index, sample));
  FrameCamera camera;
  place_eye(camera, sample.eye, index.header.anchor, index.step_m());
  const glm::dvec3 forward = glm::normalize(sample.target - sample.eye);
  const glm::dvec3 up = std::abs(forward.z) > 0.9999 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1);
  const glm::dvec3 right = glm::normalize(glm::cross(forward, up));
  camera.forward = glm::vec3(forward);
  camera.right = glm::vec3(right);
  camera.up = glm::vec3(glm::cross(right, forward));
  camera.fov_y_deg = static_cast<float>(sample.fov_y_deg);
  double diagonal = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double extent = static_cast<double>(index.header.bounds_max[i]) - index.header.bounds_min[i];
    diagonal += extent * extent;
  }
  camera.ray_length_m = static_cast<float>(std::max(100.0, 2 * std::sqrt(diagonal) * camera.step_m));
  return camera;
}

}  // namespace zc
