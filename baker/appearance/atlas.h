// SPDX-License-Identifier: GPL-3.0-or-later
// Places of charts in an atlas, and the atlas as the page contains it. Charts stand on whole 4 × 4 blocks with gutters,
// so that filtering and the coarser levels stay within them. Deterministic. Thread-safe: no state.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "baker/appearance/charts.h"
#include "baker/appearance/resample.h"

namespace zc {

struct AtlasLayout {
  std::uint32_t width = 0;  // texels, powers of two
  std::uint32_t height = 0;
  double texels_per_step = 0;
  std::vector<ChartRaster> rasters;                 // of each chart; without size: too small to show anything
  std::vector<std::array<std::uint32_t, 2>> place;  // of the raster's first texel
};

// The finest of the densities `finest`, finest / 2^¼, … at which the charts fit max_size²; in the smallest atlas that
// contains them. Charts of no more than two texels have no place. Nothing when no chart has one.
std::optional<AtlasLayout> lay_out_atlas(std::span<const Chart* const> charts, double finest, std::uint32_t max_size);

struct EncodedAtlas {
  std::uint32_t size = 0;             // as gpu::PageHeader::atlas_size
  std::vector<std::uint32_t> blocks;  // BC1, level by level
};

// Of an atlas of size² texels with all its levels.
std::uint32_t atlas_bytes(std::uint32_t size);

// texels: of each chart of the layout.
EncodedAtlas encode_atlas(const AtlasLayout& layout, std::span<const ChartTexels> texels);

}  // namespace zc
