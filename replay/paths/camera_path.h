// SPDX-License-Identifier: Apache-2.0
// A recorded camera path: CSV (`time_s,eye_x,eye_y,eye_z,target_x,target_y,target_z,fov_y_deg`) or a file of named
// still views (`{"shots": [{"name", "eye", "target", "fov_y_deg"}]}`), one second apart. Units: world CRS, metres, z
// up; seconds; degrees. Untrusted input. Thread-safe: plain values. Fails, naming the line, on anything that is not a
// finite camera in ascending time.
#pragma once

#include <algorithm>
#include <cstdint>
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

// Samples of a path, by their places.
struct FrameRange {
  std::uint64_t begin = 0;
  std::uint64_t end = UINT64_MAX;  // exclusive
  std::uint64_t step = 1;

  // What of it lies on the path.
  [[nodiscard]] FrameRange within(const CameraPath& path) const {
    return {begin, std::min<std::uint64_t>(end, path.size()), step};
  }
  [[nodiscard]] std::uint64_t count() const { return begin < end ? (end - begin - 1) / step + 1 : 0; }
  [[nodiscard]] std::uint64_t at(std::uint64_t i) const { return begin + i * step; }
};

Result<CameraPath> read_camera_path(const std::filesystem::path& file);

// The camera at a time: between samples as eye_at() and alike for target and field of view; still views do not move.
CameraSample camera_at(const CameraPath& path, double time_s);

// The eye at a time, linear between samples, held before the first and after the last.
glm::dvec3 eye_at(const CameraPath& path, double time_s);

// What a frame's picture is called: the view's name, or the frame's number in six digits.
std::string frame_name(const CameraSample& sample, std::uint64_t frame);

}  // namespace zc
