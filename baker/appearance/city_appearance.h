// SPDX-License-Identifier: GPL-3.0-or-later
// Surface attributes and atlases of all zones. Deterministic at any thread count.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "baker/appearance/texture_source.h"
#include "baker/scene/bake_context.h"
#include "streamer/world_format/bvh_page.h"

namespace zc {

struct AppearanceInput {
  std::span<const ZoneMesh> meshes;  // decoded
  std::span<const NodeRecord> nodes;
  std::uint32_t atlas_size = 0;  // of a leaf; half that of its parent, and so on; 0: no atlases
  double step_m = 0;
  // Of the whole city:
  const TextureSource& textures;  // of a zone: what lies within its box and the reach of its error
  std::span<const Material> materials;
};

struct CityAppearance {
  std::vector<ZoneAppearance> zones;       // per node
  std::vector<std::uint32_t> atlas_sizes;  // per node, texels a side that it may have at most; empty: no atlases
};

Result<CityAppearance> make_appearances(AppearanceInput&& input, BakeContext& context);

}  // namespace zc
