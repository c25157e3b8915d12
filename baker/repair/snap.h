// SPDX-License-Identifier: GPL-3.0-or-later
// Snaps a scene to the world lattice, once, before anything is repaired or cut.
// Owns what it returns. Fails when the scene is empty, refers to what is not there, or is wider than the lattice.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "baker/scene/bake_context.h"
#include "baker/scene/lattice_mesh.h"
#include "baker/scene/scene.h"
#include "base/result.h"

namespace zc {

struct SnappedScene {
  WorldLattice lattice;
  LatticeMesh mesh;                  // welded; coordinates >= 0
  std::vector<SceneObject> objects;  // contiguous, in order, cover all faces; none empty
  std::vector<Material> materials;   // at least one
  std::string crs;
  std::vector<ImportCount> notes;
};

struct SnapInput {
  Scene scene;
  // Of the whole city:
  WorldLattice lattice;  // fit_lattice
};

// The lattice of a whole city.
Result<WorldLattice> fit_lattice(const Scene& scene, std::int32_t step_log2);

Result<SnappedScene> snap_scene(SnapInput&& input, BakeContext& context);

}  // namespace zc
