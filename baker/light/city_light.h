// SPDX-License-Identifier: GPL-3.0-or-later
// Light of all zones of a world. A zone's light depends on the full detail within the reach of its rays, and sunlight
// on what stands towards the suns: zones are lit region by region, each over a scene of just that, so that what one
// bake found holds in the next wherever nothing near changed, and so that the scenes stay small however large the city
// is. The same for the same world at any number of threads.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "baker/light/zone_light.h"
#include "baker/scene/bake_cache.h"
#include "baker/scene/bake_context.h"

namespace zc {

struct LightInput {
  std::span<const NodeRecord> nodes;
  std::optional<SunAngles> sun;  // what it reaches is stored too
  double step_m = 0;
  BakeCache& cache;
  // Of the whole city: of a zone, the full detail within the reach of its rays, and what stands towards the suns.
  std::span<const ZoneMesh> meshes;  // decoded, per node
  std::span<const Material> materials;
};

struct CityLight {
  std::vector<std::vector<gpu::TriangleLight>> zones;  // per node, as bake_zone_light
  std::uint64_t reused = 0;                            // zones whose light the cache had
  std::uint64_t built = 0;
};

// Fails when Embree does.
Result<CityLight> light_city(LightInput&& input, BakeContext& context);

}  // namespace zc
