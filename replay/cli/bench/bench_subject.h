// SPDX-License-Identifier: Apache-2.0
// What `zonecast bench` measures on: the triangles of a world, of a raw file or of the generated city, cut into zones
// as a bake cuts them, and a camera where rays are to come from one. Joins the baker. Units: metres. Thread-safe: no
// state. Fails as imports, worlds and camera paths do, and as bench_scene.h says.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>

#include "baker/bake.h"
#include "replay/bench/bench_scene.h"

namespace zc::bench {

struct SubjectOptions {
  std::string world, triangles;                                 // at most one; neither: the generated city
  SourceOptions source;                                         // of the world
  double size_km = 0.5;                                         // of that
  std::uint32_t leaf_triangles = BakeOptions{}.leaf_triangles;  // most of a zone; those of a world are as they are
  bool camera = false;                                          // whether to take one
  std::string path;                                             // where from; empty: the generated city's still views
  std::uint64_t frame = 0;
  double world_offset_m = 0;  // moves the scene east and north
};

struct Subject {
  BenchScene scene;
  std::optional<CameraSample> camera;
  glm::dvec3 frame_m = {};  // the local origin in the frame of raw triangles
};

Result<Subject> open_subject(const SubjectOptions& options);

}  // namespace zc::bench
