// SPDX-License-Identifier: GPL-3.0-or-later
// Paints a chart from the source's textures: every texel takes the colour of the source surface that lies closest to it
// along the chart's axis. Deterministic. Thread-safe: no state.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "baker/appearance/charts.h"
#include "baker/appearance/texture_source.h"

namespace zc {

// Where a chart's texels lie: texel i covers (i + first) / texels_per_step to (i + first + 1) / texels_per_step.
struct ChartRaster {
  std::array<std::int32_t, 2> first = {};
  std::array<std::uint32_t, 2> size = {};  // gutters included
  double texels_per_step = 0;

  bool operator==(const ChartRaster&) const = default;
};

struct ChartTexels {
  std::vector<glm::vec3> colors;  // linear, rows; every texel has one where any source was found
  glm::vec3 mean{0};              // over the texels on the chart's triangles
  float deviation = 0;            // root mean square of those from the mean, of 8-bit sRGB
  bool painted = false;           // false: no source lies near
};

// A zone's own frame: world steps = origin + (zone steps << step_shift).
struct ZoneFrame {
  glm::dvec3 origin{0};
  double steps = 1;  // of the world in one of the zone
};

// reach: how far a source may lie from the chart, in zone steps.
ChartTexels resample(const ZoneMesh& mesh, const Chart& chart, const ChartRaster& raster, const ZoneFrame& frame,
                     std::span<const SourceTriangle* const> sources, const TextureSource& textures,
                     std::span<const Material> materials, double reach);

}  // namespace zc
