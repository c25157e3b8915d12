// SPDX-License-Identifier: GPL-3.0-or-later
// Implicit tiling: 3D Tiles 1.1, section 8, and the extensions of 1.0 that came before it.
#include <cmath>
#include <glm/trigonometric.hpp>
#include <sstream>

#include "baker/geo/earth_frame.h"
#include "tests/unit/baker/import/tiles/tiles_support.h"

namespace zc::test {
namespace {

using Names = std::vector<std::string>;

std::string subtree_file(std::string json, const std::string& binary) {
  while (json.size() % 8 != 0) json += ' ';
  std::string file = "subt";
  append(file, std::uint32_t{1});
  append(file, std::uint64_t{json.size()});
  append(file, std::uint64_t{binary.size()});
  return file + json + binary;
}

class ImplicitTiles : public Tiles {
 protected:
  static std::string implicit(const std::string& scheme, int levels, int subtree_levels, const std::string& name) {
    return R"("implicitTiling":{"subdivisionScheme":")" + scheme + R"(","availableLevels":)" + std::to_string(levels) +
           R"(,"subtreeLevels":)" + std::to_string(subtree_levels) + R"(,"subtrees":{"uri":")" + name + R"("}})";
  }
  static std::string constants(int tiles, int contents, int children) {
    return R"({"tileAvailability":{"constant":)" + std::to_string(tiles) + R"(},"contentAvailability":[{"constant":)" +
           std::to_string(contents) + R"(}],"childSubtreeAvailability":{"constant":)" + std::to_string(children) + "}}";
  }
  void write_models(std::initializer_list<const char*> tiles, const std::string& kind = "") const {
    for (const char* tile : tiles) write(kind + tile + ".glb", model("", kind + tile));
  }
};

// Two levels: the root and, in Morton order, (0,0), (1,0), (0,1), (1,1); the bits of each are listed, lowest first.
TEST_F(ImplicitTiles, QuadtreesShowTheFinestWhereTilesReplaceAndAllWhereTheyAdd) {
  write_models({"0_0_0", "1_1_0", "1_0_1"});
  // Tiles: root, (1,0), (0,1), (1,1). Contents: root, (1,0), (0,1).
  const std::string binary{"\x1D\0\0\0\0\0\0\0\x0D\0\0\0\0\0\0\0", 16};
  write("0.0.0.subtree",
        subtree_file(R"({"buffers":[{"byteLength":16}],"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":1},)"
                     R"({"buffer":0,"byteOffset":8,"byteLength":1}],"tileAvailability":{"bitstream":0},)"
                     R"("contentAvailability":[{"bitstream":1,"availableCount":3}],)"
                     R"("childSubtreeAvailability":{"constant":0}})",
                     binary));
  const auto tiles = [&](const std::string& refine) {
    return tileset(tile(moved(0, 0, 7) + R"(,"refine":")" + refine + R"(",)" + content("{level}_{x}_{y}.glb") + "," +
                        implicit("QUADTREE", 2, 2, "{level}.{x}.{y}.subtree")));
  };
  const Scene finest = shown(tiles("REPLACE"));
  EXPECT_EQ(names(finest), (Names{"1_1_0", "1_0_1"}));
  ASSERT_FALSE(finest.positions.empty());
  EXPECT_EQ(finest.positions[0], glm::dvec3(0, 0, 7));
  EXPECT_EQ(names(shown(tiles("ADD"))), (Names{"1_1_0", "1_0_1", "0_0_0"}));
}

TEST_F(ImplicitTiles, ChildSubtreesBeginWhereTheirParentsEnd) {
  // Subtrees of one level: every tile is the root of its own.
  write_models({"2_2_1", "1_0_1"});
  const auto children = [](unsigned bits) {
    return subtree_file(
        R"({"buffers":[{"byteLength":1}],"bufferViews":[{"buffer":0,"byteLength":1}],"tileAvailability":)"
        R"({"constant":1},"contentAvailability":[{"constant":0}],"childSubtreeAvailability":{"bitstream":0}})",
        std::string(1, static_cast<char>(bits)));
  };
  std::filesystem::create_directories(folder_ / "s");
  write("s/0_0_0", children(0b0110));  // (1,0) and (0,1)
  write("s/1_1_0", children(0b0100));  // (0,1) of it: (2,1)
  write("s/1_0_1", constants(1, 1, 0));
  write("s/2_2_1", constants(1, 1, 1));  // below is no level
  EXPECT_EQ(names(shown(
                tileset(tile(content("{level}_{x}_{y}.glb") + "," + implicit("QUADTREE", 3, 1, "s/{level}_{x}_{y}"))))),
            (Names{"2_2_1", "1_0_1"}));
}

TEST_F(ImplicitTiles, OctreesHaveAThirdCoordinate) {
  write_models({"1_1_0_1", "1_0_1_1"});
  // Morton order: x is the lowest bit, then y, then z: (1,0,1) is 5, (0,1,1) is 6; one bit earlier comes the root.
  const std::string bits{"\xC1\0", 2};
  write("bits.bin", bits);
  write("0.json", R"({"buffers":[{"uri":"bits.bin","byteLength":2}],"bufferViews":[{"buffer":0,"byteLength":2}],)"
                  R"("tileAvailability":{"bitstream":0},"contentAvailability":{"bitstream":0},)"
                  R"("childSubtreeAvailability":{"constant":0}})");
  write_models({"0_0_0_0"});
  EXPECT_EQ(names(shown(tileset(tile(content("{level}_{x}_{y}_{z}.glb") + "," + implicit("OCTREE", 2, 2, "0.json"))))),
            (Names{"1_1_0_1", "1_0_1_1"}));
}

TEST_F(ImplicitTiles, EveryContentHasItsOwnAvailability) {
  write_models({"0_0_0"}, "a");
  write_models({"1_0_0", "1_1_0", "1_0_1", "1_1_1"}, "b");
  write("0.subtree", subtree_file(R"({"buffers":[{"byteLength":2}],"bufferViews":[{"buffer":0,"byteLength":1},)"
                                  R"({"buffer":0,"byteOffset":1,"byteLength":1}],"tileAvailability":{"constant":1},)"
                                  R"("contentAvailability":[{"bitstream":0},{"bitstream":1}],)"
                                  R"("childSubtreeAvailability":{"constant":0}})",
                                  "\x01\x1E"));
  const std::string templates = R"([{"uri":"a{level}_{x}_{y}.glb"},{"uri":"b{level}_{x}_{y}.glb"}])";
  const Names all{"b1_0_0", "b1_1_0", "b1_0_1", "b1_1_1", "a0_0_0"};
  EXPECT_EQ(names(shown(tileset(
                tile(R"("refine":"ADD","contents":)" + templates + "," + implicit("QUADTREE", 2, 2, "0.subtree"))))),
            all);
  // As 1.0 had it: two extensions of the tile, and one of the subtree.
  write("0.subtree",
        subtree_file(R"({"buffers":[{"byteLength":2}],"bufferViews":[{"buffer":0,"byteLength":1},)"
                     R"({"buffer":0,"byteOffset":1,"byteLength":1}],"tileAvailability":{"constant":1},)"
                     R"("extensions":{"3DTILES_multiple_contents":{"contentAvailability":[{"bufferView":0},)"
                     R"({"bufferView":1}]}},"childSubtreeAvailability":{"constant":0}})",
                     "\x01\x1E"));
  EXPECT_EQ(
      names(shown(tileset(tile(R"("refine":"ADD","extensions":{"3DTILES_multiple_contents":{"content":)" + templates +
                               R"(},"3DTILES_implicit_tiling":{"subdivisionScheme":"QUADTREE","maximumLevel":1,)" +
                               R"("subtreeLevels":2,"subtrees":{"uri":"0.subtree"}}})"),
                          R"("version":"1.0")",
                          R"("extensionsRequired":["3DTILES_implicit_tiling","3DTILES_multiple_contents"],)"))),
      all);
}

TEST_F(ImplicitTiles, ATileOfItsOwnSaysWhereAWideTilingIsOnTheEarth) {
  const Geodetic place{11.425, 48.765, 370};
  const glm::dvec3 center = geocentric_of(place);
  std::ostringstream features;
  features.precision(17);
  features << R"({"RTC_CENTER":[)" << center.x << "," << center.y << "," << center.z << "]}";
  write("c.b3dm", b3dm(features.str()));
  const int level = 10;
  // A region as wide as the earth: 180 degrees of longitude and 90 of latitude from 0, 0, cut ten times.
  const auto x = static_cast<int>(place.lon_deg / 180 * 1024);
  const auto y = static_cast<int>(place.lat_deg / 90 * 1024);
  for (int at = 0; at <= level; ++at) {
    const int shift = level - at;
    unsigned child = 0;
    if (at < level) child = 1U << static_cast<unsigned>((x >> (shift - 1) & 1) + 2 * (y >> (shift - 1) & 1));
    write(std::to_string(at) + "_" + std::to_string(x >> shift) + "_" + std::to_string(y >> shift) + ".subtree",
          subtree_file(R"({"buffers":[{"byteLength":1}],"bufferViews":[{"buffer":0,"byteLength":1}],)"
                       R"("tileAvailability":{"constant":1},"contentAvailability":[{"constant":)" +
                           std::string(at == level ? "1" : "0") + R"(}],"childSubtreeAvailability":{"bitstream":0}})",
                       std::string(1, static_cast<char>(child))));
  }
  const Scene scene =
      shown(tileset(R"({"boundingVolume":{"region":[0,0,3.14159265,1.57079632,0,500]},"geometricError":0,)" +
                    content("c.b3dm") + "," + implicit("QUADTREE", 11, 1, "{level}_{x}_{y}.subtree") + "}"));
  ASSERT_EQ(scene.positions.size(), 3U);
  EXPECT_NE(scene.crs.find("ENU of EPSG:4978"), std::string::npos) << scene.crs;
  // Within the tile of 20 km, not 5000 km from it.
  EXPECT_LT(glm::length(scene.positions[0]), 20'000);
}

TEST_F(ImplicitTiles, DamagedTilingsAndSubtreesAreRefused) {
  write_models({"0"});
  const auto refused = [&](const std::string& bytes, const std::string& words) {
    write("0.subtree", bytes);
    expect_refused(tileset(tile(content("0.glb") + "," + implicit("QUADTREE", 2, 2, "0.subtree"))), words, "0.subtree");
  };
  const std::string good = subtree_file(
      R"({"buffers":[{"byteLength":1}],"bufferViews":[{"buffer":0,"byteLength":1}],"tileAvailability":{"bitstream":0},)"
      R"("childSubtreeAvailability":{"constant":0}})",
      "\x01");
  for (std::size_t length = 0; length < good.size(); ++length) refused(good.substr(0, length), "");
  refused(subtree_file(R"({"tileAvailability":{"bitstream":0},"childSubtreeAvailability":{"constant":0}})", ""),
          "bufferView 0");
  refused(subtree_file(R"({"buffers":[{"byteLength":2}],"bufferViews":[{"buffer":0,"byteLength":1}],)"
                       R"("tileAvailability":{"bitstream":0},"childSubtreeAvailability":{"constant":0}})",
                       "\x01"),
          "1 exist");
  refused(subtree_file(R"({"buffers":[{"byteLength":1}],"bufferViews":[{"buffer":0,"byteOffset":1,"byteLength":1}],)"
                       R"("tileAvailability":{"bitstream":0},"childSubtreeAvailability":{"constant":0}})",
                       "\x01"),
          "reaches past");
  refused(constants(2, 1, 0), "neither 0 nor 1");
  refused(R"({"tileAvailability":{"constant":1}})", "no childSubtreeAvailability");
  const auto refused_tiling = [&](const std::string& tiling, const std::string& words) {
    expect_refused(tileset(tile(content("0.glb") + "," + tiling)), words);
  };
  refused_tiling(implicit("BINARY", 2, 2, "0.subtree"), "expected QUADTREE or OCTREE");
  refused_tiling(implicit("QUADTREE", 0, 2, "0.subtree"), "availableLevels");
  refused_tiling(implicit("QUADTREE", 99, 2, "0.subtree"), "99 levels");
  refused_tiling(implicit("OCTREE", 4, 2, "{level}{x}{y}"), "without {z}");
  refused_tiling(implicit("QUADTREE", 2, 2, "0.subtree") + R"(,"children":[{}])", "of which a tile has one");
}

TEST_F(ImplicitTiles, OneBitForAllTilesEndsAtTheBound) {
  write("0.subtree", constants(1, 0, 0));
  expect_refused(tileset(tile(content("{level}_{x}_{y}.glb") + "," + implicit("QUADTREE", 14, 14, "0.subtree"))),
                 "more than 4194304 tiles");
  write("0.subtree", constants(1, 1, 0));
  expect_refused(tileset(tile(R"("refine":"ADD",)" + content("{level}_{x}_{y}.glb") + "," +
                              implicit("QUADTREE", 14, 14, "0.subtree"))),
                 "more than 524288 contents");
}

}  // namespace
}  // namespace zc::test
