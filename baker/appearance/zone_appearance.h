// SPDX-License-Identifier: GPL-3.0-or-later
// The surface attributes and the atlas of a zone whose source is textured: charts that show a picture share one atlas,
// charts of one colour become that colour, and everything else keeps its material. Deterministic. Thread-safe: no
// state.
#pragma once

#include <cstdint>
#include <span>

#include "baker/appearance/texture_source.h"
#include "streamer/world_format/bvh_page.h"

namespace zc {

struct AtlasOptions {
  std::uint32_t max_size = 512;  // texels, a power of two
  double texels_per_m = 16;      // no finer
};

// Appearances, atlas and nothing else; empty when no triangle's material is textured. node: of the mesh.
ZoneAppearance make_zone_appearance(const ZoneMesh& mesh, const NodeRecord& node, const TextureSource& source,
                                    std::span<const Material> materials, double step_m, const AtlasOptions& options);

}  // namespace zc
