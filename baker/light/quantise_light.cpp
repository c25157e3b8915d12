// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/light/quantise_light.h"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "streamer/world_format/coding/light_order.h"

namespace zc {
namespace {

constexpr std::uint32_t kSkyLimit = 6;  // of 255: one ray of the 48 towards the sky
// Red, green and blue by one 31st, the share by one 63rd, the variation by one 64th.
constexpr std::array<std::uint32_t, 5> kLevelSteps = {1, 2, 1, 1, 4};
constexpr std::uint32_t kDirectionStep = 1;

void take(std::uint32_t& value, std::uint32_t neighbour, std::uint32_t limit) {
  const auto change = static_cast<std::int64_t>(value) - static_cast<std::int64_t>(neighbour);
  if (std::abs(change) <= limit) value = neighbour;
}

// To the middle of its step; what sees all of the sky stays so.
std::uint32_t quantise_sky(std::uint32_t sky) {
  std::uint32_t out = 0;
  for (unsigned k = 0; k < 3; ++k) {
    const std::uint32_t value = sky >> (8 * k) & 0xFFU;
    const std::uint32_t step = 2 * kSkyLimit + 1;
    out |= (value >= 255 - kSkyLimit ? 255 : std::min((value + kSkyLimit) / step * step, 255 / step * step)) << (8 * k);
  }
  return out;
}

}  // namespace

void quantise_light(const ZoneMesh& mesh, std::span<gpu::TriangleLight> light) {
  LightOrder order(mesh);
  for (std::uint32_t t = 0; t < light.size(); ++t) {
    const LightOrder::Place place = order.place(t);
    const std::uint32_t sky = quantise_sky(light[t].sky);
    BouncedLight bounce(light[t]);
    if (place.neighbour != LightOrder::kNone) {
      const BouncedLight other(light[place.neighbour]);
      for (std::size_t f = 0; f < kLevelSteps.size(); ++f) take(bounce.levels[f], other.levels[f], kLevelSteps[f]);
      for (std::size_t a = 0; a < 2; ++a) take(bounce.direction[a], other.direction[a], kDirectionStep);
    }
    light[t] = bounce.pack();
    light[t].sky |= sky;
    order.add(t, place.facing);
  }
}

}  // namespace zc
