// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/light/quantise_light.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <random>

#include "streamer/world_format/coding/light_order.h"

namespace zc {
namespace {

ZoneMesh ground(std::uint16_t cells) {
  ZoneMesh mesh;
  for (std::uint16_t y = 0; y <= cells; ++y)
    for (std::uint16_t x = 0; x <= cells; ++x)
      mesh.vertices.push_back({static_cast<std::uint16_t>(10 * x), static_cast<std::uint16_t>(10 * y), 0});
  for (std::uint32_t y = 0; y < cells; ++y)
    for (std::uint32_t x = 0; x < cells; ++x) {
      const std::uint32_t at = y * (cells + 1U) + x;
      mesh.triangles.push_back({at, at + 1, at + cells + 2});
      mesh.triangles.push_back({at, at + cells + 2, at + cells + 1});
    }
  return mesh;
}

gpu::TriangleLight light_of(std::uint32_t sky, std::uint32_t level) {
  BouncedLight bounce;
  bounce.levels = {level, level, level, level, 4 * level};
  bounce.direction = {level, level};
  gpu::TriangleLight light = bounce.pack();
  light.sky |= sky * 0x010101U;
  return light;
}

TEST(QuantiseLight, NoiseBecomesOneValue) {
  const ZoneMesh mesh = ground(8);
  std::vector<gpu::TriangleLight> light;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    light.push_back(t % 2 == 0 ? light_of(200, 7) : light_of(195, 8));
  quantise_light(mesh, light);
  for (const gpu::TriangleLight& l : light) {
    EXPECT_EQ(l.sky, light[0].sky);
    EXPECT_EQ(l.bounce, light[0].bounce);
  }
}

TEST(QuantiseLight, NothingMovesByMoreThanItSays) {
  const ZoneMesh mesh = ground(20);
  std::mt19937 random(7);
  std::vector<gpu::TriangleLight> before;
  std::uint32_t sky = 128;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    sky = (sky + static_cast<std::uint32_t>(random() % 9) - 4) &
          0xFFU;  // a slope, in steps that are each below the noise
    gpu::TriangleLight light{static_cast<std::uint32_t>(random()) & 0xFF000000U, static_cast<std::uint32_t>(random())};
    light.sky |= sky | (sky + static_cast<std::uint32_t>(random() % 5)) % 256 << 8U | sky << 16U;
    before.push_back(light);
  }
  std::vector<gpu::TriangleLight> after = before;
  quantise_light(mesh, after);
  const auto apart = [](std::uint32_t a, std::uint32_t b) {
    return std::abs(static_cast<int>(a) - static_cast<int>(b));
  };
  std::size_t moved = 0;
  for (std::size_t t = 0; t < before.size(); ++t) {
    for (unsigned k = 0; k < 3; ++k)
      EXPECT_LE(apart(before[t].sky >> (8 * k) & 0xFFU, after[t].sky >> (8 * k) & 0xFFU), 6);
    const BouncedLight b(before[t]);
    const BouncedLight a(after[t]);
    for (std::size_t f = 0; f < 5; ++f) EXPECT_LE(apart(a.levels[f], b.levels[f]), f == 4 ? 4 : f == 1 ? 2 : 1);
    for (std::size_t d = 0; d < 2; ++d) EXPECT_LE(apart(a.direction[d], b.direction[d]), 1);
    EXPECT_EQ(a.sun, b.sun);
    moved += after[t].sky != before[t].sky ? 1 : 0;
  }
  EXPECT_GT(moved, before.size() / 10);
}

}  // namespace
}  // namespace zc
