// SPDX-License-Identifier: GPL-3.0-or-later
// The first stages of a bake, over a whole scene.
#pragma once

#include <gtest/gtest.h>

#include <utility>

#include "baker/cut/cut.h"
#include "baker/repair/snap.h"

namespace zc::test {

inline Result<SnappedScene> snap(Scene scene, std::int32_t step_log2 = -8) {
  BakeContext context;
  ZC_ASSIGN(const WorldLattice lattice, fit_lattice(scene, step_log2));
  return snap_scene({std::move(scene), lattice}, context);
}

inline SnappedScene snapped(Scene scene) {
  Result<SnappedScene> out = snap(std::move(scene));
  EXPECT_TRUE(out.ok()) << out.error().describe();
  return *std::move(out);
}

inline CutScene cut(SnappedScene scene, std::uint32_t leaf_triangles, std::uint32_t leaf_shift = 30) {
  BakeContext context;
  const CellGrid grid = fit_cells(scene, leaf_triangles);
  return *cut_zones({std::move(scene), leaf_triangles, leaf_shift, grid}, context);
}

}  // namespace zc::test
