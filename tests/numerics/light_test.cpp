// SPDX-License-Identifier: GPL-3.0-or-later
// Baked light against what is known of simple scenes, and against sums over many more rays.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "baker/light/zone_light.h"

namespace zc {
namespace {

constexpr double kStepM = 1.0 / 256;
constexpr double kPi = 3.14159265358979;

// One detail node, and proxies of it.
class Yard {
 public:
  Yard() {
    node_.flags = kNodeDetail;
    materials_.resize(3);
    materials_[0].base_color = {0.5F, 0.5F, 0.5F};
    materials_[1].base_color = {0.8F, 0.2F, 0.1F};
    materials_[2].base_color = {0.9F, 0.9F, 0.9F};
  }

  // Four corners, anticlockwise as seen from outside; cut into cells × cells squares.
  void quad(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d, std::uint16_t material,
            int cells = 1) {
    const auto at = [&](int i, int j) {
      const double u = static_cast<double>(i) / cells;
      const double v = static_cast<double>(j) / cells;
      const glm::dvec3 p = glm::mix(glm::mix(a, b, u), glm::mix(d, c, u), v);
      mesh_.vertices.push_back({static_cast<std::uint16_t>(std::lround(p.x / kStepM)),
                                static_cast<std::uint16_t>(std::lround(p.y / kStepM)),
                                static_cast<std::uint16_t>(std::lround(p.z / kStepM))});
      return static_cast<std::uint32_t>(mesh_.vertices.size() - 1);
    };
    for (int j = 0; j < cells; ++j)
      for (int i = 0; i < cells; ++i) {
        const std::array corner = {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)};
        mesh_.triangles.push_back({corner[0], corner[1], corner[2]});
        mesh_.triangles.push_back({corner[0], corner[2], corner[3]});
        mesh_.materials.insert(mesh_.materials.end(), 2, material);
      }
  }
  void box(const glm::dvec3& low, const glm::dvec3& high, std::uint16_t material) {
    const auto at = [&](int x, int y, int z) {
      return glm::dvec3(x ? high.x : low.x, y ? high.y : low.y, z ? high.z : low.z);
    };
    quad(at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1), material);
    quad(at(1, 0, 0), at(1, 1, 0), at(1, 1, 1), at(1, 0, 1), material);
    quad(at(1, 1, 0), at(0, 1, 0), at(0, 1, 1), at(1, 1, 1), material);
    quad(at(0, 1, 0), at(0, 0, 0), at(0, 0, 1), at(0, 1, 1), material);
    quad(at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1), material);
  }

  [[nodiscard]] LightScene scene() {
    node_.triangle_count = static_cast<std::uint32_t>(mesh_.triangles.size());
    auto built = LightScene::build({&mesh_, 1}, {&node_, 1}, materials_, kStepM, 2);
    EXPECT_TRUE(built.ok());
    return std::move(built).value();
  }
  [[nodiscard]] std::vector<gpu::TriangleLight> light(const std::optional<SunAngles>& sun = {}) {
    return bake_zone_light(mesh_, node_, scene(), sun, kStepM);
  }

  ZoneMesh mesh_;
  NodeRecord node_;
  std::vector<Material> materials_;
};

double sky_at(const gpu::TriangleLight& light, std::size_t corner) { return (light.sky >> 8 * corner & 255U) / 255.0; }
std::uint32_t sun_state(const gpu::TriangleLight& light) { return light.bounce >> 22U & 3U; }

// As shaders/baked_light.glsl has it, for sunlight of one.
glm::dvec3 bounce_of(const gpu::TriangleLight& light, const glm::dvec3& sun) {
  const glm::dvec3 around((light.bounce >> 11U & 31U) / 31.0, (light.bounce >> 5U & 63U) / 63.0,
                          (light.bounce & 31U) / 31.0);
  glm::dvec3 most(static_cast<double>(light.bounce >> 24U & 15U) / 7.5 - 1, (light.bounce >> 28U) / 7.5 - 1, 0);
  most.z = 1 - std::abs(most.x) - std::abs(most.y);
  if (most.z < 0)
    most = glm::dvec3((1 - std::abs(most.y)) * (most.x >= 0 ? 1 : -1), (1 - std::abs(most.x)) * (most.y >= 0 ? 1 : -1),
                      most.z);
  const double share =
      (light.bounce >> 16U & 63U) / 63.0 + (light.sky >> 24U) / 255.0 * glm::dot(glm::normalize(most), sun);
  return around * std::max(share, 0.0);
}

TEST(Light, OpenGroundNeedsNone) {
  Yard yard;
  yard.quad({0, 0, 0}, {100, 0, 0}, {100, 100, 0}, {0, 100, 0}, 0, 4);
  EXPECT_TRUE(yard.light().empty());
  const auto lit = yard.light(SunAngles{145, 38});
  ASSERT_EQ(lit.size(), 32U);
  for (const gpu::TriangleLight& t : lit) EXPECT_EQ(sun_state(t), gpu::kSunLit);
}

TEST(Light, GroundBesideALongWallSeesAsMuchSkyAsTheViewFactorSays) {
  // A wall of height h along y = 0, 200 m long: at a distance d the sky's share is (1 + d / sqrt(d² + h²)) / 2.
  constexpr double kHeight = 10;
  Yard yard;
  for (int i = 0; i < 40; ++i)
    yard.quad({98, 1.0 * i, 0}, {102, 1.0 * i, 0}, {102, 1.0 * i + 1, 0}, {98, 1.0 * i + 1, 0}, 0);
  yard.quad({0, 0, 0}, {0, 0, kHeight}, {200, 0, kHeight}, {200, 0, 0}, 1);
  const auto light = yard.light();
  ASSERT_EQ(light.size(), 82U);
  double worst = 0;
  for (std::size_t t = 0; t < 80; ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const double d = yard.mesh_.vertices[yard.mesh_.triangles[t][k]][1] * kStepM;
      if (d < 1) continue;  // samples stand back from the very corner
      const double expected = (1 + d / std::hypot(d, kHeight)) / 2;
      worst = std::max(worst, std::abs(sky_at(light[t], k) - expected));
    }
  EXPECT_LT(worst, 0.06);
}

TEST(Light, ClosedRoomsAreDarkAndTheirOutsidesAreNot) {
  Yard yard;
  yard.box({10, 10, 0}, {20, 20, 8}, 2);
  yard.quad({10, 10, 0}, {10, 20, 0}, {20, 20, 0}, {20, 10, 0}, 0);  // the floor seen from below
  const std::size_t inside = yard.mesh_.triangles.size();
  yard.quad({12, 12, 0.5}, {18, 12, 0.5}, {18, 18, 0.5}, {12, 18, 0.5}, 0);  // a carpet
  const auto light = yard.light(SunAngles{145, 38});
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(sky_at(light[inside], k), 0);
  EXPECT_EQ(sun_state(light[inside]), gpu::kSunShadow);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_GT(sky_at(light[8], k), 0.95) << "roof";
}

TEST(Light, WallsSendTheirColourOfSunlightOn) {
  Yard yard;
  constexpr int kCells = 10;
  yard.quad({40, 0, 0}, {60, 0, 0}, {60, 20, 0}, {40, 20, 0}, 0, kCells);
  yard.quad({0, 20, 0}, {100, 20, 0}, {100, 20, 30}, {0, 20, 30}, 1);  // red, faces south
  const LightScene scene = yard.scene();
  const auto light = bake_zone_light(yard.mesh_, yard.node_, scene, {}, kStepM);
  // The same at the ground's triangles from very many rays, for suns in front of the wall, beside it and behind.
  // What a mean and a direction cannot say of a wall that the sun only grazes is allowed for.
  for (const auto& [sun, tolerance] :
       {std::pair{SunAngles{180, 40}, 0.1}, {SunAngles{90, 35}, 0.13}, {SunAngles{0, 50}, 0.03}}) {
    const glm::dvec3 to_sun(sun_direction(sun));
    double sum = 0;
    double expected_sum = 0;
    for (std::size_t t = 0; t < 2 * kCells * kCells; ++t) {
      glm::dvec3 center(0);
      for (const std::uint32_t v : yard.mesh_.triangles[t])
        center +=
            glm::dvec3(yard.mesh_.vertices[v][0], yard.mesh_.vertices[v][1], yard.mesh_.vertices[v][2]) * (kStepM / 3);
      // The wall is lit where it faces the sun, and nothing shades it.
      double share = 0;
      constexpr int kMany = 64;
      for (int i = 0; i < kMany; ++i)
        for (int j = 0; j < kMany; ++j) {
          const double radius = std::sqrt((i + 0.5) / kMany);
          const double turn = 2 * kPi * (j + 0.5) / kMany;
          const glm::dvec3 d(radius * std::cos(turn), radius * std::sin(turn), std::sqrt(1 - radius * radius));
          if (d.y <= 0) continue;
          const double far = (20 - center.y) / d.y;
          const double x = center.x + far * d.x;
          const double z = far * d.z;
          if (x < 0 || x > 100 || z > 30) continue;
          share += std::max(-to_sun.y, 0.0) / (kMany * kMany);
        }
      const glm::dvec3 got = bounce_of(light[t], to_sun);
      EXPECT_NEAR(got.r, 0.8 * share, tolerance) << sun.azimuth_deg << ' ' << t;
      EXPECT_LT(got.g, 0.35 * got.r + 0.01);
      sum += got.r;
      expected_sum += 0.8 * share;
    }
    EXPECT_NEAR(sum / (2 * kCells * kCells), expected_sum / (2 * kCells * kCells), 0.85 * tolerance) << sun.azimuth_deg;
  }
}

TEST(Light, TheSunIsSettledWhereATriangleIsWhollyLitOrShaded) {
  Yard yard;
  constexpr int kCells = 16;
  yard.quad({0, 0, 0}, {32, 0, 0}, {32, 32, 0}, {0, 32, 0}, 0, kCells);
  yard.box({12, 12, 0}, {18, 18, 6}, 2);
  const SunAngles sun{180, 45};  // from the south: the shadow reaches 6 m to the north
  const auto light = yard.light(sun);
  const auto state_at = [&](double x, double y) {
    for (std::size_t t = 0; t < 2 * kCells * kCells; ++t) {
      const auto& tri = yard.mesh_.triangles[t];
      glm::dvec2 low(1e9);
      glm::dvec2 high(-1e9);
      for (const std::uint32_t v : tri) {
        const glm::dvec2 p(yard.mesh_.vertices[v][0] * kStepM, yard.mesh_.vertices[v][1] * kStepM);
        low = glm::min(low, p);
        high = glm::max(high, p);
      }
      if (x > low.x && x < high.x && y > low.y && y < high.y) return sun_state(light[t]);
    }
    return 99U;
  };
  EXPECT_EQ(state_at(5, 5), gpu::kSunLit);
  EXPECT_EQ(state_at(15, 9), gpu::kSunLit);
  EXPECT_EQ(state_at(15, 21), gpu::kSunShadow);
  EXPECT_EQ(state_at(15, 27), gpu::kSunLit);
}

// A pole's shadow on a large square: neither of its triangles is all in the sun, wherever the pole stands.
TEST(Light, ANarrowShadowOnALargeTriangleIsNotOverlooked) {
  const SunAngles sun{200, 45};
  Yard open;
  open.quad({0, 0, 0}, {24, 0, 0}, {24, 24, 0}, {0, 24, 0}, 0);
  for (const gpu::TriangleLight& t : open.light(sun)) EXPECT_EQ(sun_state(t), gpu::kSunLit);
  for (const glm::dvec2 at : {glm::dvec2(12, 4), {11.3, 8.7}, {14.1, 10.9}, {4.6, 7.2}, {20.2, 3.9}}) {
    Yard yard;
    yard.quad({0, 0, 0}, {24, 0, 0}, {24, 24, 0}, {0, 24, 0}, 0);
    yard.box({at.x, at.y, 0}, {at.x + 0.6, at.y + 0.6, 5}, 2);
    const auto light = yard.light(sun);
    EXPECT_TRUE(sun_state(light[0]) == gpu::kSunUnknown || sun_state(light[1]) == gpu::kSunUnknown)
        << at.x << ", " << at.y;
  }
}

TEST(Light, AProxyWithinTheBodyHasTheLightOfTheSurface) {
  Yard yard;
  yard.quad({0, 0, 0}, {60, 0, 0}, {60, 60, 0}, {0, 60, 0}, 0);
  yard.box({20, 20, 0}, {40, 40, 12}, 2);
  const LightScene scene = yard.scene();
  const SunAngles sun{200, 50};
  const auto detail = bake_zone_light(yard.mesh_, yard.node_, scene, sun, kStepM);
  Yard proxy;
  proxy.quad({0, 0, 0}, {60, 0, 0}, {60, 60, 0}, {0, 60, 0}, 0);
  proxy.box({20.5, 20.5, 0}, {39.5, 39.5, 11.5}, 2);
  proxy.node_.flags = 0;
  proxy.node_.error_max_m = 0.9F;
  const auto light = bake_zone_light(proxy.mesh_, proxy.node_, scene, sun, kStepM);
  ASSERT_EQ(light.size(), detail.size());
  for (std::size_t t = 2; t < light.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(sky_at(light[t], k), sky_at(detail[t], k), 0.1) << t;
    EXPECT_EQ(sun_state(light[t]), sun_state(detail[t])) << t;
  }
}

// A fan of slivers half a kilometre long, whose boxes all lie over each other: rays see it cut into pieces.
TEST(LightScene, LongTrianglesAskewAreHitAsTheyAre) {
  constexpr int kBlades = 2000;
  const auto rim = [](int i) {
    const double turn = 2 * kPi * i / kBlades;
    return LatticePoint{static_cast<std::int32_t>(128000 * (1 + std::cos(turn))),
                        static_cast<std::int32_t>(128000 * (1 + std::sin(turn))), 256 * (i * 7 % 5)};
  };
  LatticeMesh fan;
  fan.vertices.push_back({128000, 128000, 0});
  for (int i = 0; i < 2 * kBlades; ++i) fan.vertices.push_back(rim(i / 2 + i % 2));
  for (std::uint32_t i = 0; i < kBlades; ++i) fan.faces.push_back({{0, 2 * i + 1, 2 * i + 2}});
  const LightDetail detail(fan, kStepM);
  auto device = LightDevice::create();
  ASSERT_TRUE(device.ok());
  const std::uint32_t all = 0;
  const auto scene = LightScene::build(*device, detail, std::span(&all, 1), {glm::dvec3(0), detail.bias_m});
  ASSERT_TRUE(scene.ok());
  EXPECT_GT(scene->primitives(), 4U * kBlades);
  for (std::uint32_t i = 0; i < kBlades; i += 3) {
    const std::span<const glm::vec3> corner(&detail.corners[3 * std::size_t{i}], 3);
    for (const float near : {0.02F, 0.3F, 0.9F}) {  // of the way from the hub
      const glm::vec3 p = corner[0] + near * ((corner[1] + corner[2]) * 0.5F - corner[0]);
      const auto hit = scene->closest(p + glm::vec3(0, 0, 50), {0, 0, -1}, 1000);
      ASSERT_TRUE(hit);
      EXPECT_NEAR(hit->distance_m, 50, 2e-3) << i;
      EXPECT_EQ(hit->triangle, i);
    }
  }
}

}  // namespace
}  // namespace zc
