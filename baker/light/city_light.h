// SPDX-License-Identifier: GPL-3.0-or-later
// Light of all zones of a world. A zone's light depends on the full detail within the reach of its rays, and sunlight
// on what stands towards the suns: zones are lit region by region, each over a scene of just that, so that what one
// bake found holds in the next wherever nothing near changed, and so that the scenes stay small however large the city
// is. The same for the same world at any number of threads.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "baker/light/zone_light.h"
#include "baker/scene/bake_cache.h"

namespace zc {

struct CityLight {
  std::vector<std::vector<gpu::TriangleLight>> zones;  // per node, as bake_zone_light
  std::uint64_t reused = 0;                            // zones whose light the cache had
  std::uint64_t built = 0;
};

// meshes and nodes: of the whole world, decoded; done: after every node, from any thread. Fails when Embree refuses.
Result<CityLight> light_city(std::span<const ZoneMesh> meshes, std::span<const NodeRecord> nodes,
                             std::span<const Material> materials, const std::optional<SunAngles>& sun, double step_m,
                             unsigned threads, BakeCache& cache, const std::function<void()>& done);

}  // namespace zc
