// SPDX-License-Identifier: GPL-3.0-or-later
// Walls with textures into surface attributes and atlases, read back as the shaders read them.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "baker/appearance/zone_appearance.h"
#include "streamer/world_format/page_view.h"

namespace zc {
namespace {

constexpr std::int32_t kStepLog2 = -8;
constexpr double kStepM = 1.0 / 256;

std::uint32_t mixed(std::uint32_t x) {
  x = (x ^ x >> 16U) * 0x7FEB352DU;
  x = (x ^ x >> 15U) * 0x846CA68BU;
  return x ^ x >> 16U;
}

using Pattern = std::function<glm::uvec3(std::uint32_t x, std::uint32_t y)>;  // 0..255, sRGB

TextureImage image_of(std::uint32_t width, std::uint32_t height, const Pattern& pattern) {
  std::vector<std::uint8_t> pixels;
  for (std::uint32_t y = 0; y < height; ++y)
    for (std::uint32_t x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) pixels.push_back(static_cast<std::uint8_t>(pattern(x, y)[c]));
  return make_texture_image(pixels, width, height, 3);
}

// Upright quads, each with its own corner, direction and material; texture coordinates in `per_m` of the wall's metres.
struct Walls {
  Scene scene;
  ZoneMesh mesh;
  NodeRecord node;

  void add(const glm::dvec2& from, const glm::dvec2& to, double height, std::uint16_t material, float per_m) {
    const std::array<glm::dvec3, 4> corner = {glm::dvec3(from, 0), glm::dvec3(to, 0), glm::dvec3(to, height),
                                              glm::dvec3(from, height)};
    const auto wide = static_cast<float>(glm::distance(from, to)) * per_m;
    const auto high = static_cast<float>(height) * per_m;
    const std::array<glm::vec2, 4> uv = {glm::vec2(0, high), {wide, high}, {wide, 0}, {0, 0}};
    for (const auto& [a, b, c] : {std::array{0, 1, 2}, std::array{0, 2, 3}}) {
      const auto t = static_cast<std::uint32_t>(scene.triangles.size());
      const auto base = static_cast<std::uint32_t>(scene.positions.size());
      for (const int k : {a, b, c}) {
        const auto& p = corner[static_cast<std::size_t>(k)];
        scene.positions.push_back(p);
        std::array<std::uint16_t, 3> q{};
        for (int axis = 0; axis < 3; ++axis)
          q[static_cast<std::size_t>(axis)] = static_cast<std::uint16_t>(std::lround(p[axis] / kStepM));
        mesh.vertices.push_back(q);
        node.bounds_max = {std::max<std::int32_t>(node.bounds_max[0], q[0]),
                           std::max<std::int32_t>(node.bounds_max[1], q[1]),
                           std::max<std::int32_t>(node.bounds_max[2], q[2])};
      }
      scene.triangles.push_back({base, base + 1, base + 2});
      mesh.triangles.push_back({base, base + 1, base + 2});
      scene.triangle_material.push_back(material);
      mesh.materials.push_back(material);
      scene.texcoords.push_back(
          {t, {uv[static_cast<std::size_t>(a)], uv[static_cast<std::size_t>(b)], uv[static_cast<std::size_t>(c)]}});
    }
  }
  std::uint16_t paint(const TextureImage& image, glm::vec3 factor = glm::vec3(1)) {
    scene.images.push_back(image);
    Material material;
    material.texture = SurfaceTexture{.image = static_cast<std::uint32_t>(scene.images.size() - 1), .factor = factor};
    scene.materials.push_back(material);
    return static_cast<std::uint16_t>(scene.materials.size() - 1);
  }
  ZoneAppearance appearances(const AtlasOptions& options = {}) {
    const TextureSource source(scene, {{0, 0, 0}, kStepLog2});
    return make_zone_appearance(mesh, node, source, scene.materials, kStepM, options);
  }
};

// As shaders/page_appearance.glsl reads the first level.
class Atlas {
 public:
  explicit Atlas(const ZoneAppearance& appearance)
      : appearance_(appearance), shape_(AtlasShape::unpack(appearance.atlas_size)) {}

  [[nodiscard]] glm::vec3 color(std::uint32_t triangle, const glm::dvec3& steps) const {
    const gpu::Appearance appearance = appearance_.appearances[appearance_.appearance_of[triangle]];
    if ((appearance.material >> 16U & 3U) == gpu::kAppearanceColor)
      return gain(appearance) * glm::vec3(srgb8_to_linear(appearance.place & 255U),
                                          srgb8_to_linear(appearance.place >> 8U & 255U),
                                          srgb8_to_linear(appearance.place >> 16U & 255U));
    const std::uint32_t axis = appearance.material >> 18U & 3U;
    const glm::dvec2 plane = axis == 0 ? glm::dvec2(steps.y, steps.z)
                                       : (axis == 1 ? glm::dvec2(steps.x, steps.z) : glm::dvec2(steps.x, steps.y));
    const glm::dvec2 moved(static_cast<std::int16_t>(appearance.place & 0xFFFFU),
                           static_cast<std::int16_t>(appearance.place >> 16U));
    const glm::dvec2 at = plane * static_cast<double>(appearance_.texels_per_step) + moved - 0.5;
    const glm::dvec2 low = glm::floor(at);
    const glm::vec2 part(at - low);
    const auto texel_at = [&](int x, int y) {
      return texel(static_cast<std::uint32_t>(low.x) + static_cast<std::uint32_t>(x),
                   static_cast<std::uint32_t>(low.y) + static_cast<std::uint32_t>(y));
    };
    const glm::vec3 c = glm::mix(glm::mix(texel_at(0, 0), texel_at(1, 0), part.x),
                                 glm::mix(texel_at(0, 1), texel_at(1, 1), part.x), part.y);
    return c * gain(appearance);
  }

 private:
  static float gain(const gpu::Appearance& appearance) {
    return std::exp2(-static_cast<float>(appearance.material >> 23U & 255U) / 32);
  }
  [[nodiscard]] glm::vec3 texel(std::uint32_t x, std::uint32_t y) const {
    const std::uint32_t row = (1U << shape_.width_log2) / 4;
    const std::uint32_t word = 2 * (y / 4 * row + x / 4);
    const std::uint32_t ends = appearance_.atlas[word];
    const std::uint32_t index = appearance_.atlas[word + 1] >> (2 * (4 * (y % 4) + x % 4)) & 3U;
    const auto rgb = [](std::uint32_t c) {
      return glm::vec3(static_cast<float>(c >> 11U & 31U) / 31, static_cast<float>(c >> 5U & 63U) / 63,
                       static_cast<float>(c & 31U) / 31);
    };
    const glm::vec3 first = rgb(ends & 0xFFFFU);
    const glm::vec3 second = rgb(ends >> 16U);
    const std::array<float, 4> part = {0, 1, 1.0F / 3, 2.0F / 3};
    const glm::vec3 c = glm::mix(first, second, part[index]);
    return {srgb_to_linear(c.r), srgb_to_linear(c.g), srgb_to_linear(c.b)};
  }

  const ZoneAppearance& appearance_;
  AtlasShape shape_;
};

std::uint32_t kind_of(const ZoneAppearance& appearance, std::uint32_t triangle) {
  return appearance.appearances[appearance.appearance_of[triangle]].material >> 16U & 3U;
}

glm::vec3 mean_over_wall(const Atlas& atlas, const glm::dvec2& from, const glm::dvec2& to, double height) {
  glm::dvec3 sum(0);
  constexpr int kSamples = 256;
  for (int i = 0; i < kSamples; ++i)
    for (int j = 0; j < kSamples; ++j) {
      const glm::dvec2 p = glm::mix(from, to, (i + 0.5) / kSamples);
      sum += glm::dvec3(atlas.color(0, glm::dvec3(p, height * (j + 0.5) / kSamples) / kStepM));
    }
  return glm::vec3(sum / double{kSamples * kSamples});
}

TEST(Appearance, TheMeanColourOfAWallIsItsTextures) {
  const std::vector<std::pair<const char*, Pattern>> patterns = {
      {"bright noise", [](auto x, auto y) { return glm::uvec3(120 + mixed(x + 512 * y) % 100); }},
      {"dark noise", [](auto x, auto y) { return glm::uvec3(20 + mixed(x + 512 * y) % 30); }},
      {"coloured noise",
       [](auto x, auto y) {
         const std::uint32_t h = mixed(x + 512 * y);
         return glm::uvec3(h % 256, (h >> 8U) % 120, (h >> 16U) % 60);
       }},
      {"bricks",
       [](auto x, auto y) {
         return y % 32 < 4 || (x + y / 32 % 2 * 32) % 64 < 4 ? glm::uvec3(190, 185, 170) : glm::uvec3(140, 60, 40);
       }},
      {"stripes", [](auto x, auto) { return x % 16 < 8 ? glm::uvec3(230, 10, 10) : glm::uvec3(10, 200, 60); }},
  };
  for (const auto& [name, pattern] : patterns) {
    for (const glm::dvec2 direction : {glm::dvec2(1, 0), glm::dvec2(0.8, 0.6)}) {
      Walls walls;
      const TextureImage image = image_of(256, 256, pattern);
      const glm::vec3 factor(1, 0.7F, 0.9F);
      const std::uint16_t material = walls.paint(image, factor);
      const glm::dvec2 from(4, 4);
      const glm::dvec2 to = from + 12.0 * direction;
      walls.add(from, to, 8, material, 0.25F);
      const ZoneAppearance appearance = walls.appearances();
      ASSERT_TRUE(direction.y > 0 || kind_of(appearance, 0) == gpu::kAppearanceTextured) << name;
      const glm::vec3 got = mean_over_wall(Atlas(appearance), from, to, 8);
      const glm::vec3 wanted = image.mean * factor;
      const glm::vec3 luminance(0.2126F, 0.7152F, 0.0722F);
      EXPECT_NEAR(glm::dot(got, luminance), glm::dot(wanted, luminance), 0.02F * glm::dot(wanted, luminance)) << name;
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(got[c], wanted[c], 0.02F * std::max({wanted.r, wanted.g, wanted.b}))
            << name << ", channel " << c << ", direction " << direction.y;
    }
  }
}

TEST(Appearance, PointsOfAWallShowTheTexelsOfTheirPlace) {
  Walls walls;
  const TextureImage ramp = image_of(512, 512, [](auto x, auto y) { return glm::uvec3(x / 2, y / 2, 128); });
  const std::uint16_t material = walls.paint(ramp);
  walls.add({3, 5}, {13, 5}, 10, material, 0.1F);  // faces -y
  const ZoneAppearance appearance = walls.appearances();
  const Atlas atlas(appearance);
  for (const double x : {0.11, 0.37, 0.5, 0.83})
    for (const double z : {0.07, 0.46, 0.92}) {
      const glm::vec3 c = atlas.color(0, glm::dvec3(3 + 10 * x, 5, 10 * z) / kStepM);
      EXPECT_NEAR(linear_to_srgb8(c.r), 255 * x, 6) << x << ' ' << z;
      EXPECT_NEAR(linear_to_srgb8(c.g), 255 * (1 - z), 6) << x << ' ' << z;
    }
}

TEST(Appearance, WallsBackToBackKeepTheirOwnSides) {
  Walls walls;
  const auto noise = [](std::uint32_t channel) {
    return [channel](auto x, auto y) {
      glm::uvec3 c(30);
      c[static_cast<int>(channel)] = 130 + mixed(x + 512 * y) % 120;
      return c;
    };
  };
  const std::uint16_t red = walls.paint(image_of(128, 128, noise(0)));
  const std::uint16_t green = walls.paint(image_of(128, 128, noise(1)));
  walls.add({2, 2}, {12, 2}, 6, red, 0.5F);
  walls.add({12, 2}, {2, 2}, 6, green, 0.5F);  // in the same place, facing away
  walls.add({12, 2.05}, {2, 2.05}, 6, green, 0.5F);
  const ZoneAppearance appearance = walls.appearances();
  const Atlas atlas(appearance);
  for (const double x : {2.5, 7.0, 11.5})
    for (const double z : {0.5, 3.0, 5.5}) {
      const glm::vec3 front = atlas.color(0, glm::dvec3(x, 2, z) / kStepM);
      const glm::vec3 back = atlas.color(2, glm::dvec3(x, 2, z) / kStepM);
      EXPECT_GT(front.r, 2 * front.g);
      EXPECT_GT(back.g, 2 * back.r);
    }
}

TEST(Appearance, AnyNumberIsATextureCoordinateAndAColour) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<std::uint8_t> pixels(std::size_t{3} * 5 * 3, 200);
  const TextureImage image = make_texture_image(pixels, 5, 3, 3);
  for (const float u : {kNan, kInfinity, -kInfinity, 3e38F, -3e38F, 0.3F})
    for (const float v : {kNan, -kInfinity, -1e30F, 0.7F})
      for (const TextureWrap wrap : {TextureWrap::kRepeat, TextureWrap::kMirror, TextureWrap::kClamp})
        EXPECT_EQ(linear_to_srgb8(image.sample({u, v}, 1, wrap, wrap).g), 200) << u << ' ' << v;
  EXPECT_EQ(linear_to_srgb8(kNan), 0);
  EXPECT_EQ(linear_to_srgb8(kInfinity), 255);
}

TEST(Appearance, WhatShowsNothingNeedsNoAtlas) {
  Walls flat;
  const TextureImage grey = image_of(64, 64, [](auto x, auto) { return glm::uvec3(x % 2 == 0 ? 100 : 101); });
  flat.add({1, 1}, {9, 1}, 5, flat.paint(grey), 1);
  const ZoneAppearance appearance = flat.appearances();
  EXPECT_TRUE(appearance.atlas.empty());
  ASSERT_EQ(kind_of(appearance, 0), gpu::kAppearanceColor);
  EXPECT_NEAR(Atlas(appearance).color(0, glm::dvec3(0)).g, grey.mean.g, 0.02F * grey.mean.g);

  Walls plain;
  plain.scene.materials.emplace_back();
  plain.add({1, 1}, {9, 1}, 5, 0, 1);
  plain.scene.texcoords.clear();
  EXPECT_TRUE(plain.appearances().appearances.empty());
}

TEST(Appearance, ManyChartsShareASmallAtlasMoreCoarsely) {
  Walls walls;
  const std::uint16_t material = walls.paint(
      image_of(128, 128, [](auto x, auto y) { return glm::uvec3(60 + mixed(x / 16 + 64 * (y / 16)) % 180); }));
  for (int i = 0; i < 60; ++i)
    walls.add({1.0 + i % 10 * 6, 1.0 + i / 10 * 6}, {5.0 + i % 10 * 6, 1.0 + i / 10 * 6}, 4, material, 0.25F);
  const ZoneAppearance fine = walls.appearances();
  Walls again = walls;
  for (std::uint32_t t = 0; t < again.mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = again.scene.triangles[t];
    EXPECT_EQ(kind_of(fine, t), gpu::kAppearanceTextured) << t << ' ' << a << b << c;
  }
  EXPECT_LE(fine.atlas.size(), 512U * 512 / 16 * 2 * 4 / 3 + 16);
}

}  // namespace
}  // namespace zc
