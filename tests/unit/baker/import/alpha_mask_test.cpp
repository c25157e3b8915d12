// SPDX-License-Identifier: GPL-3.0-or-later
// What a mask keeps of triangles, by area and by place.
#include "baker/import/images/alpha_mask.h"

#include <gtest/gtest.h>
#include <webp/encode.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <memory>
#include <string>

#include "tests/unit/baker/import/import_support.h"

namespace zc {
namespace {

// Alpha 255 where `opaque`, else 0.
template <class Opaque>
AlphaMask mask(std::uint32_t side, const Opaque& opaque) {
  std::vector<std::uint8_t> pixels;
  for (std::uint32_t y = 0; y < side; ++y)
    for (std::uint32_t x = 0; x < side; ++x) {
      pixels.push_back(100);
      pixels.push_back(opaque((x + 0.5) / side, (y + 0.5) / side) ? 255 : 0);
    }
  return {pixels, side, side, 2};
}

const std::vector<AlphaMask::Triangle> kQuad = {{{{{0, 0}, {1, 0}, {1, 1}}}}, {{{{0, 0}, {1, 1}, {0, 1}}}}};

glm::vec2 place(const AlphaMask::Triangle& triangle, const glm::vec3& shares) {
  return shares.x * triangle.uv[0] + shares.y * triangle.uv[1] + shares.z * triangle.uv[2];
}

// Twice-signed: pieces turn as their triangle does.
double area(const AlphaMask::Cut& cut, const std::vector<AlphaMask::Triangle>& triangles) {
  double sum = 0;
  for (std::size_t i = 0; i < cut.pieces.size(); ++i) {
    const AlphaMask::Triangle& of = triangles[cut.of[i]];
    const auto turn = [](const glm::vec2& a, const glm::vec2& b, const glm::vec2& c) {
      return static_cast<double>((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)) / 2;
    };
    const double own = turn(place(of, cut.pieces[i][0]), place(of, cut.pieces[i][1]), place(of, cut.pieces[i][2]));
    EXPECT_GT(own * turn(of.uv[0], of.uv[1], of.uv[2]), 0) << "turned over";
    sum += std::abs(own);
  }
  return sum;
}

bool in_disc(double x, double y) { return std::hypot(x - 0.5, y - 0.5) < 0.3; }

TEST(AlphaMask, KeepsWhatIsOpaqueAndNothingElse) {
  const AlphaMask disc = mask(256, in_disc);
  const AlphaMask::Cut cut = disc.cut(kQuad, TextureWrap::kRepeat, TextureWrap::kRepeat, 0.5F, 100'000);
  EXPECT_NEAR(area(cut, kQuad), M_PI * 0.09, 0.001);
  for (std::size_t i = 0; i < cut.pieces.size(); ++i)
    for (const glm::vec3& corner : cut.pieces[i]) {
      const glm::vec2 at = place(kQuad[cut.of[i]], corner);
      EXPECT_LT(std::hypot(at.x - 0.5, at.y - 0.5), 0.3 + 1.0 / 256);
    }
}

TEST(AlphaMask, TakesACoarserLevelWhereAFinerGivesTooMany) {
  const AlphaMask disc = mask(256, in_disc);
  const AlphaMask::Cut fine = disc.cut(kQuad, TextureWrap::kRepeat, TextureWrap::kRepeat, 0.5F, 100'000);
  const AlphaMask::Cut coarse = disc.cut(kQuad, TextureWrap::kRepeat, TextureWrap::kRepeat, 0.5F, 200);
  EXPECT_GT(fine.pieces.size(), 500U);
  EXPECT_LE(coarse.pieces.size(), 200U);
  EXPECT_NEAR(area(coarse, kQuad), M_PI * 0.09, 0.05);
}

TEST(AlphaMask, ThinWiresDoNotVanishAtCoarseLevels) {
  const AlphaMask wires = mask(256, [](double x, double) { return std::fmod(x * 16, 1.0) < 0.2; });
  const AlphaMask::Cut cut = wires.cut(kQuad, TextureWrap::kRepeat, TextureWrap::kRepeat, 0.5F, 150);
  EXPECT_LE(cut.pieces.size(), 150U) << "a straight bar is few pieces however long";
  EXPECT_NEAR(area(cut, kQuad), 3.0 / 16, 0.01);
  // Leaves that no level shows one by one: as much is kept as was there.
  const auto is_leaf = [](double x, double y) {
    const auto cell = static_cast<std::uint32_t>(x * 256) * 7919U + static_cast<std::uint32_t>(y * 256) * 104729U;
    return (cell * 2654435761U >> 24U) < 77;  // of 256
  };
  const AlphaMask::Cut leaves = mask(256, is_leaf).cut(kQuad, TextureWrap::kRepeat, TextureWrap::kRepeat, 0.5F, 1000);
  EXPECT_LE(leaves.pieces.size(), 1000U);
  EXPECT_NEAR(area(leaves, kQuad), 0.3, 0.1);
}

TEST(AlphaMask, FollowsHowTheTextureIsRepeated) {
  const AlphaMask left = mask(64, [](double x, double) { return x < 0.5; });
  const std::vector<AlphaMask::Triangle> wide = {{{{{0, 0}, {4, 0}, {4, 1}}}}, {{{{0, 0}, {4, 1}, {0, 1}}}}};
  const auto kept = [&](TextureWrap wrap) {
    return area(left.cut(wide, wrap, TextureWrap::kClamp, 0.5F, 100'000), wide);
  };
  EXPECT_NEAR(kept(TextureWrap::kRepeat), 2, 0.1);
  EXPECT_NEAR(kept(TextureWrap::kMirror), 2, 0.1);
  EXPECT_NEAR(kept(TextureWrap::kClamp), 0.5, 0.05);
}

TEST(AlphaMask, LeavesWholeWhatHasNoHolesAndKeepsWhatItCannotCut) {
  EXPECT_TRUE(mask(16, [](double, double) { return true; })
                  .cut(kQuad, TextureWrap::kRepeat, TextureWrap::kRepeat, 0.5F, 100)
                  .is_whole);
  const AlphaMask disc = mask(64, in_disc);
  const float none = std::nanf("");
  const std::vector<AlphaMask::Triangle> odd = {
      {{{{0, 0}, {0, 0}, {1, 1}}}}, {{{{none, 0}, {1, 0}, {1, 1}}}}, {{{{0, 0}, {1e9F, 0}, {1e9F, 1e9F}}}}};
  const AlphaMask::Cut cut = disc.cut(odd, TextureWrap::kRepeat, TextureWrap::kRepeat, 0.5F, 100);
  EXPECT_EQ(cut.of, (std::vector<std::uint32_t>{0, 1, 2}));
}

// A square of one metre with the left half of its texture at one alpha and the right half at another.
class AlphaMode : public test::ImportTest {
 protected:
  Result<Scene> square(std::uint8_t left, std::uint8_t right, const std::string& material, double factor = 1) const {
    constexpr int kSide = 64;
    std::vector<std::uint8_t> pixels;
    for (int i = 0; i < kSide * kSide; ++i)
      for (const int value : {200, 100, 50, static_cast<int>(i % kSide < kSide / 2 ? left : right)})
        pixels.push_back(static_cast<std::uint8_t>(value));
    std::uint8_t* out = nullptr;
    const std::size_t size = WebPEncodeLosslessRGBA(pixels.data(), kSide, kSide, 4 * kSide, &out);
    const std::unique_ptr<std::uint8_t, decltype(&WebPFree)> owned(out, &WebPFree);
    write("a.webp", {reinterpret_cast<const char*>(out), size});
    std::string bin;
    for (const float value : {0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 1.F, 1.F, 0.F, 0.F, 1.F, 0.F}) test::append(bin, value);
    for (const float value : {0.F, 0.F, 1.F, 0.F, 1.F, 1.F, 0.F, 1.F}) test::append(bin, value);
    for (const int index : {0, 1, 2, 0, 2, 3}) test::append(bin, static_cast<std::uint16_t>(index));
    write("a.bin", bin);
    return import_text(
        "a.gltf",
        R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0,)"
        R"("TEXCOORD_0":1},"indices":2,"material":0}]}],"images":[{"uri":"a.webp"}],"textures":[{"extensions":)"
        R"({"EXT_texture_webp":{"source":0}}}],"materials":[{)" +
            material + R"("pbrMetallicRoughness":{"baseColorFactor":[1,1,1,)" + std::to_string(factor) +
            R"(],"baseColorTexture":{"index":0}}}],"accessors":[{"bufferView":0,"componentType":5126,"count":4,)"
            R"("type":"VEC3"},{"bufferView":1,"componentType":5126,"count":4,"type":"VEC2"},{"bufferView":2,)"
            R"("componentType":5123,"count":6,"type":"SCALAR"}],"bufferViews":[{"buffer":0,"byteLength":48},)"
            R"({"buffer":0,"byteOffset":48,"byteLength":32},{"buffer":0,"byteOffset":80,"byteLength":12}],)"
            R"("buffers":[{"byteLength":92,"uri":"a.bin"}]})");
  }
};

TEST_F(AlphaMode, MaskedSurfacesEndWhereTheirTextureDoes) {
  const auto masked = square(255, 0, R"("alphaMode":"MASK",)");
  ASSERT_TRUE(masked.ok()) << masked.error().describe();
  EXPECT_NEAR(test::area(*masked), 0.5, 0.02);
  for (const glm::dvec3& p : masked->positions) EXPECT_LT(p.x, 0.52);
  EXPECT_EQ(test::noted(*masked, "transparent parts"), 2U);
  EXPECT_FALSE(masked->texcoords.empty());
  // The cutoff, and the material's own alpha, count.
  EXPECT_NEAR(test::area(*square(255, 100, R"("alphaMode":"MASK","alphaCutoff":0.3,)")), 1, 1e-9);
  EXPECT_NEAR(test::area(*square(255, 100, R"("alphaMode":"MASK","alphaCutoff":0.3,)", 0.5)), 0.5, 0.02);
  EXPECT_FALSE(square(255, 100, R"("alphaMode":"MASK",)", 0.4).ok()) << "nothing is left";
}

TEST_F(AlphaMode, BlendedSurfacesKeepWhatIsMostlyOpaqueAndPanesAreKeptWhole) {
  EXPECT_NEAR(test::area(*square(200, 20, R"("alphaMode":"BLEND",)")), 0.5, 0.02);
  const auto pane = square(80, 80, R"("alphaMode":"BLEND",)");
  ASSERT_TRUE(pane.ok());
  EXPECT_NEAR(test::area(*pane), 1, 1e-9);
  EXPECT_EQ(test::noted(*pane, "kept as panes"), 2U);
}

TEST_F(AlphaMode, OpaqueSurfacesIgnoreTheirAlpha) {
  EXPECT_NEAR(test::area(*square(255, 0, "")), 1, 1e-9);
  EXPECT_NEAR(test::area(*square(255, 0, R"("alphaMode":"OPAQUE",)")), 1, 1e-9);
}

}  // namespace
}  // namespace zc
