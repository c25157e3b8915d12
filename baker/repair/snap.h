// SPDX-License-Identifier: GPL-3.0-or-later
// Snaps a scene to the world lattice, once, before anything is repaired or cut.
// Owns what it returns. Fails when the scene is empty, or wider than the lattice holds.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "baker/scene/lattice_mesh.h"
#include "baker/scene/scene.h"
#include "base/result.h"

namespace zc {

struct SnappedScene {
  std::array<std::int64_t, 3> anchor = {};  // lattice units, whole metres
  std::int32_t step_log2 = -8;
  LatticeMesh mesh;                  // welded over the whole world; coordinates >= 0
  std::vector<SceneObject> objects;  // contiguous, in order, cover all faces; none empty
  std::vector<Material> materials;   // at least one
  std::string crs;
  std::vector<ImportCount> notes;
};

// step_log2 in [-16, 0]: steps divide the metre, so that the anchor is whole in both.
Result<SnappedScene> snap_scene(Scene&& scene, std::int32_t step_log2);

}  // namespace zc
