// SPDX-License-Identifier: GPL-3.0-or-later
// Reads city models of every supported format into one Scene: glTF 2.0 and GLB (Draco, quantised), CityJSON 1.1 and
// 2.0, CityJSONSeq, CityGML 1.0, 2.0 and 3.0, 3D Tiles 1.0 and 1.1, OBJ, PLY; as files, packed with gzip or in a ZIP
// archive, or as a folder of them. What was left out or replaced is counted in Scene::notes. Units: metres in the
// inputs' CRS, z up (glTF's y up is turned; geocentric tilesets get a local frame). Untrusted input. Thread-safe: no
// state. Fails when a file is unreadable, does not follow its format or needs what is not handled; when inputs name
// different coordinate reference systems and one is not known; when nothing has a triangle.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "baker/import/shared/material_rules.h"
#include "baker/import/shared/world_placement.h"
#include "baker/scene/scene.h"
#include "base/result.h"

namespace zc {

struct ImportOptions {
  std::vector<Placement> placements;  // none: as the inputs have it; one: of all inputs; or one for each
  bool skip_missing = false;          // tiles that are not there are counted instead of an error
  MaterialRules materials;
  bool ground_plane = false;
  std::optional<double> ground_plane_z_m;  // else at the lowest point
};

// Reads every input (its format by content, not by extension) and merges them into one scene, in order. Folders and
// archives give their models in the order of their paths; what in them is no city model is noted. A pipe, or "-"
// for standard input, gives CityJSONSeq, which is not kept in memory; its images lie in the current folder.
// A web address gives 3D Tiles.
Result<Scene> import_inputs(std::span<const std::filesystem::path> inputs, const ImportOptions& options = {});

}  // namespace zc
