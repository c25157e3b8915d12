// SPDX-License-Identifier: Apache-2.0
// A recorded camera path: CSV (`time_s,eye_x,eye_y,eye_z,target_x,target_y,target_z,fov_y_deg`) or a file of named
// still views (`{"shots": [{"name", "eye", "target", "fov_y_deg"}]}`), one second apart. Units: world CRS, metres, z
// up; seconds; degrees. Untrusted input. Thread-safe: plain values. Fails, naming the line, on anything that is not a
// finite camera in ascending time.
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "base/result.h"

namespace zc {

struct CameraSample {
  double time_s = 0;
  glm::dvec3 eye = {};
  glm::dvec3 target = {};
  double fov_y_deg = 60;
  std::string name = {};  // of a still view
};

using CameraPath = std::vector<CameraSample>;  // never empty

Result<CameraPath> read_camera_path(const std::filesystem::path& file);

// The camera at a time: between samples as eye_at() and alike for target and field of view; still views do not move.
CameraSample camera_at(const CameraPath& path, double time_s);

// The eye at a time, linear between samples, held before the first and after the last.
glm::dvec3 eye_at(const CameraPath& path, double time_s);

}  // namespace zc
