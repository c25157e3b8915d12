// SPDX-License-Identifier: GPL-3.0-or-later
// Light of one zone's triangles from the whole city at full detail: the share of the sky that each corner sees,
// sunlight that comes back from what is around as a function of where the sun stands, and for one sun whether each
// triangle is wholly in its light or shadow. Proxies are not quite where the city is: rays start at the surface that
// they stand for. Deterministic. Thread-safe: no state. Sources: Landis 2002, "Production-ready global illumination"
// (ambient occlusion); Deering-style octahedral packing as in shaders/octahedral.glsl.
#pragma once

#include <optional>
#include <vector>

#include "baker/light/light_scene.h"
#include "streamer/world_format/sun_angles.h"

namespace zc {

// Skylight and bounced light come from no further than this, so that a change of the city changes only what is near.
inline constexpr float kLightReachM = 128;

glm::vec3 sun_direction(const SunAngles& sun);

// Per triangle of `mesh`; empty when all of it is in full skylight, nothing shines back and no sun is asked about.
std::vector<gpu::TriangleLight> bake_zone_light(const ZoneMesh& mesh, const NodeRecord& node, const LightScene& scene,
                                                const std::optional<SunAngles>& sun, double step_m);

}  // namespace zc
