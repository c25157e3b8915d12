// SPDX-License-Identifier: GPL-3.0-or-later
// Writes what names all nodes: world.zcw, which the streamer opens, and tileset.json, which viewers open.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "baker/scene/bake_context.h"
#include "baker/scene/lattice_mesh.h"
#include "baker/scene/scene.h"
#include "baker/write/world_writer.h"
#include "streamer/world_format/sun_angles.h"
#include "streamer/world_format/world_index.h"

namespace zc {

struct IndexInput {  // all of the whole city
  decltype(WorldIndex::nodes) nodes;
  WorldLattice lattice;
  std::span<const Material> materials;
  std::string crs;
  std::optional<SunAngles> sun;  // that light was baked for
  std::uint64_t source_triangles = 0;
  const WorldWriter& writer;
};

Result<WorldIndex> write_index(IndexInput&& input, BakeContext& context);

}  // namespace zc
