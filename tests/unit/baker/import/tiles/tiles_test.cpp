// SPDX-License-Identifier: GPL-3.0-or-later
#include <array>
#include <cmath>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>
#include <sstream>

#include "baker/geo/earth_frame.h"
#include "baker/import/shared/uri.h"
#include "tests/unit/baker/import/tiles/tiles_support.h"

namespace zc::test {
namespace {

using Names = std::vector<std::string>;

TEST_F(Tiles, NestedTransformsApplyBehindTheTurnToZUp) {
  write("a.glb", model());
  // A quarter turn about z, then a shift of the parent.
  const Scene scene =
      shown(tileset(tile(moved(1e6, 2e6, 30) + R"(,"refine":"REPLACE","children":[)" +
                         tile(R"("transform":[0,1,0,0,-1,0,0,0,0,0,1,0,0.5,0,0,1],)" + content("a.glb")) + "]")));
  ASSERT_EQ(scene.positions.size(), 3U);
  EXPECT_EQ(scene.positions[0], glm::dvec3(1e6 + 0.5, 2e6, 30));
  EXPECT_EQ(scene.positions[1], glm::dvec3(1e6 + 2.5, 2e6, 30));
  EXPECT_EQ(scene.positions[2], glm::dvec3(1e6 + 0.5, 2e6 + 2, 30));
  EXPECT_GT(normal2(scene, 0).z, 0);
}

TEST_F(Tiles, TheAxisThatIsUpIsTheTilesets) {
  write("a.glb", model());
  const auto normal = [&](const char* up) {
    return normal2(shown(tileset(tile(content("a.glb")), std::string(R"("version":"1.0","gltfUpAxis":")") + up + '"')),
                   0);
  };
  EXPECT_EQ(normal("X"), glm::dvec3(0, 4, 0));  // the model's y stays
  EXPECT_EQ(normal("Y"), glm::dvec3(0, 0, 4));
  EXPECT_EQ(normal("Z"), glm::dvec3(0, 4, 0));
  EXPECT_EQ(shown(tileset(tile(content("a.glb")), R"("version":"1.0","gltfUpAxis":"X")")).positions[2],
            glm::dvec3(0, 0, 2));  // its x is up
  expect_refused(tileset(tile(content("a.glb")), R"("version":"1.0","gltfUpAxis":"W")"), "gltfUpAxis");
}

TEST_F(Tiles, ReplacedTilesAreNotShownAndAddedToTilesAre) {
  for (const char* name : {"root", "left", "right", "leaf"}) write(std::string(name) + ".glb", model("", name));
  const auto tree = [&](const std::string& refine, const std::string& inner) {
    return tileset(tile(R"("refine":")" + refine + R"(",)" + content("root.glb") + R"(,"children":[)" +
                        tile(content("left.glb") + R"(,"children":[)" + tile(R"("children":[])") + "]") + "," +
                        tile(inner + content("right.glb") + R"(,"children":[)" + tile(content("leaf.glb")) + "]") +
                        "]"));
  };
  // A child without anything to show replaces nothing.
  EXPECT_EQ(names(shown(tree("REPLACE", ""))), (Names{"left", "leaf"}));
  EXPECT_EQ(names(shown(tree("ADD", ""))), (Names{"left", "leaf", "right", "root"}));
  EXPECT_EQ(names(shown(tree("ADD", R"("refine":"REPLACE",)"))), (Names{"left", "leaf", "root"}));
  // What is replaced need not exist; what is shown must.
  std::filesystem::remove(folder_ / "root.glb");
  EXPECT_EQ(names(shown(tree("REPLACE", ""))), (Names{"left", "leaf"}));
  expect_refused(tree("ADD", ""), "cannot open", "root.glb");
  expect_refused(tree("SUBTRACT", ""), "root tile has a refine");
}

TEST_F(Tiles, SeveralContentsAndLegacyUrlsAreRead) {
  write("a b.glb", model("", "first"));
  write("b.glb", model("", "second"));
  EXPECT_EQ(names(shown(tileset(tile(R"("contents":[{"uri":"a%20b.glb"},{"url":"./x/../b.glb?v=1#top"}])")))),
            (Names{"first", "second"}));
}

TEST_F(Tiles, ExternalTilesetsStandAtTheirTile) {
  write("a.glb", model());
  std::filesystem::create_directories(folder_ / "sub");
  write("sub/part.json", tileset(tile(moved(1, 0, 0) + "," + content("../a.glb"))));
  const Scene scene = shown(tileset(tile(moved(0, 5, 0) + "," + content("sub/part.json"))));
  ASSERT_EQ(scene.positions.size(), 3U);
  EXPECT_EQ(scene.positions[0], glm::dvec3(1, 5, 0));
  // It counts as a child that replaces its parent's content.
  write("coarse.glb", model("", "coarse"));
  EXPECT_EQ(names(shown(tileset(tile(R"("refine":"REPLACE",)" + content("coarse.glb") + R"(,"children":[)" +
                                     tile(content("sub/part.json")) + "]")))),
            Names{"part"});
}

TEST_F(Tiles, CyclesOfExternalTilesetsAreRefused) {
  write("one.json", tileset(tile(content("two.json"))));
  write("two.json", tileset(tile(content("one.json"))));
  expect_refused(tileset(tile(content("one.json"))), "contains itself", "one.json");
  expect_refused(tileset(tile(content("tileset.json"))), "contains itself");
  for (int i = 0; i < 40; ++i)
    write(std::to_string(i) + ".json", tileset(tile(content(std::to_string(i + 1) + ".json"))));
  expect_refused(tileset(tile(content("0.json"))), "nest deeper", "32.json");
}

TEST_F(Tiles, NoUriLeadsOutOfTheFolder) {
  std::filesystem::create_directories(folder_ / "in");
  write("secret.glb", model());
  for (const char* uri : {"../secret.glb", "%2e%2e/secret.glb", "a/../../secret.glb", "a/%2E%2E%2f../secret.glb", "..",
                          "/etc/passwd", "file:///etc/passwd", "http://example.org/a.glb", "HTTPS://example.org/a.glb",
                          "//example.org/a.glb", "data:model/gltf-binary;base64,AAAA", "a%00.glb", "", "#a"}) {
    const auto scene = import(write("in/tileset.json", tileset(tile(content(uri)))));
    ASSERT_FALSE(scene.ok()) << uri;
    EXPECT_EQ(scene.error().code, ErrorCode::kUnsupported) << scene.error().describe();
    EXPECT_EQ(scene.error().path, (folder_ / "in/tileset.json").string());
  }
  // Nor does one of a model's buffers.
  write("secret.bin", std::string(36, '\0'));
  write("in/a.gltf", R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":36,"uri":"../secret.bin"}]})");
  const auto scene = import(write("in/tileset.json", tileset(tile(content("a.gltf")))));
  ASSERT_FALSE(scene.ok());
  EXPECT_NE(scene.error().describe().find("a.gltf: '"), std::string::npos) << scene.error().describe();
  EXPECT_NE(scene.error().message.find("leads out of the folder"), std::string::npos);
}

TEST_F(Tiles, RelativeInputsKeepTheirFolder) {
  EXPECT_EQ(*file_of_uri("b/c.glb", "tileset.json", "."), "b/c.glb");
  EXPECT_EQ(*file_of_uri("../c.glb", "../data/sub/tileset.json", "../data"), "../data/c.glb");
  EXPECT_FALSE(file_of_uri("../c.glb", "tileset.json", ".").ok());
  EXPECT_FALSE(file_of_uri("../../data2/c.glb", "../data/sub/tileset.json", "../data").ok());
  EXPECT_FALSE(file_of_uri("../data/c.glb", "../tileset.json", "..").ok());
}

TEST_F(Tiles, CentresOfB3dmMoveTheModel) {
  std::string binary;
  for (const float value : {1.F, 2.F, 3.F}) append(binary, value);
  const auto corner = [&](const std::string& bytes) {
    write("a.b3dm", bytes);
    const Scene scene = shown(tileset(tile(moved(0, 0, 100) + "," + content("a.b3dm")), R"("version":"1.0")"));
    return scene.positions.empty() ? glm::dvec3(NAN) : scene.positions[0];
  };
  EXPECT_EQ(corner(b3dm(R"({"BATCH_LENGTH":0})")), glm::dvec3(0, 0, 100));
  EXPECT_EQ(corner(b3dm("")), glm::dvec3(0, 0, 100));
  EXPECT_EQ(corner(b3dm(R"({"BATCH_LENGTH":1,"RTC_CENTER":[4000000.25,5,6]})", "", R"({"id":["x"]})")),
            glm::dvec3(4000000.25, 5, 106));
  EXPECT_EQ(corner(b3dm(R"({"RTC_CENTER":{"byteOffset":0}}  )", binary)), glm::dvec3(1, 2, 103));
  write("a.glb", model(R"("extensionsRequired":["CESIUM_RTC"],"extensions":{"CESIUM_RTC":{"center":[7,8,9]}},)"));
  EXPECT_EQ(shown(tileset(tile(content("a.glb")))).positions[0], glm::dvec3(7, 8, 9));
}

TEST_F(Tiles, EveryPrefixOfAB3dmIsAnErrorOfOneLine) {
  const std::string file = b3dm(R"({"BATCH_LENGTH":0,"RTC_CENTER":[1,2,3]})", std::string(8, '\0'), "{}");
  const std::string json = tileset(tile(content("a.b3dm")));
  write("a.b3dm", file);
  ASSERT_TRUE(import_text("tileset.json", json).ok());
  for (std::size_t length = 0; length < file.size(); ++length) {
    std::string cut = file.substr(0, length);
    write("a.b3dm", cut);
    expect_refused(json, "", "a.b3dm");
    if (length < 12) continue;
    const auto declared = static_cast<std::uint32_t>(length);
    std::memcpy(cut.data() + 8, &declared, 4);
    write("a.b3dm", cut);
    expect_refused(json, "", "a.b3dm");
  }
}

TEST_F(Tiles, WrongLengthsAndEarlyHeadersAreRefused) {
  const std::string good = b3dm(R"({"RTC_CENTER":{"byteOffset":0}})", std::string(12, '\0'));
  const std::string json = tileset(tile(content("a.b3dm")));
  for (std::size_t at = 8; at < 28; at += 4)
    for (const std::uint32_t value : {0x7FFF'FFFFU, 0xFFFF'FFFFU, 13U}) {
      std::string bad = good;
      std::memcpy(bad.data() + at, &value, 4);
      write("a.b3dm", bad);
      expect_refused(json, "", "a.b3dm");
    }
  for (const char* center : {R"({"byteOffset":4})", R"({"byteOffset":-1})", "[1,2]", R"([1,2,"3"])"}) {
    write("a.b3dm", b3dm(std::string(R"({"RTC_CENTER":)") + center + "}", std::string(12, '\0')));
    expect_refused(json, "RTC_CENTER", "a.b3dm");
  }
  write("a.b3dm", packed("b3dm", model(), {0, 0}));
  expect_refused(json, "before version 1.0", "a.b3dm");
  write("a.b3dm", packed("b3dm", model(), {0, 0, 0}));
  expect_refused(json, "before version 1.0", "a.b3dm");
  write("a.b3dm", packed("b3dm", "", {0, 0, 0, 0}));
  expect_refused(json, "no GLB", "a.b3dm");
  std::string old = good;
  old[old.find("glTF") + 4] = 1;
  write("a.b3dm", old);
  expect_refused(json, "glTF version 1.0, only 2.0 is read; convert the tileset", "a.b3dm");
}

TEST_F(Tiles, CompositesGiveTheirModelsAndNoteTheRest) {
  const std::string first = b3dm(R"({"RTC_CENTER":[1,0,0]})");
  const std::string inner = packed("cmpt", b3dm(R"({"RTC_CENTER":[2,0,0]})"), {1});
  const std::string points = packed("pnts", "", {0, 0, 0, 0});
  const std::string body = first + packed("vctr", "", {0, 0, 0, 0}) + inner + points;
  const std::string json = tileset(tile(content("a.cmpt")));
  write("a.cmpt", packed("cmpt", body, {4}));
  const Scene scene = shown(json);
  ASSERT_EQ(scene.positions.size(), 6U);
  EXPECT_EQ(scene.positions[0], glm::dvec3(1, 0, 0));
  EXPECT_EQ(scene.positions[3], glm::dvec3(2, 0, 0));
  EXPECT_EQ(noted(scene, "vctr"), 1U);
  EXPECT_EQ(noted(scene, "pnts"), 1U);
  write("a.cmpt", packed("cmpt", body, {5}));
  expect_refused(json, "content 4 of 5", "a.cmpt");
  std::string deep = first;
  for (int i = 0; i < 20; ++i) deep = packed("cmpt", deep, {1});
  write("a.cmpt", deep);
  expect_refused(json, "nests deeper", "a.cmpt");
  write("a.cmpt", "what is this");
  expect_refused(json, "neither b3dm", "a.cmpt");
}

TEST_F(Tiles, WhatIsNotHandledIsRefused) {
  write("a.glb", model());
  const std::string leaf = content("a.glb");
  expect_refused(tileset(tile(R"("implicitTiling":{"subdivisionScheme":"QUADTREE"},)" + leaf)), "implicit");
  expect_refused(tileset(tile(leaf), R"("version":"0.0")"), "'0.0'");
  expect_refused(tileset(tile(leaf), R"("version":"1.1")", R"("extensionsRequired":["EXT_far"],)"), "EXT_far");
  expect_refused(tileset(tile(R"("children":[{"transform":[1,2]}])")), "root tile/0 has a transform");
  expect_refused(tileset(tile(R"("children":{})")), "children");
  expect_refused(tileset(tile(R"("content":{"uri":7})")), "without a uri");
  expect_refused(tileset(tile(R"("contents":[3])")), "without a uri");
  expect_refused(R"({"asset":{"version":"1.0"},"geometricError":1})", "has no root");
  expect_refused(tileset("[]"), "root tile is not an object");
  expect_refused(tileset(tile(R"("children":[])")), "no triangles");
}

// The earth in known places: TR8350.2's axes, and there and back.
TEST(EarthFrame, GeodeticAndGeocentricAgree) {
  EXPECT_LT(glm::distance(geocentric_of({0, 0, 0}), glm::dvec3(6378137, 0, 0)), 1e-9);
  EXPECT_LT(glm::distance(geocentric_of({90, 0, 10}), glm::dvec3(0, 6378147, 0)), 1e-8);
  EXPECT_LT(glm::distance(geocentric_of({0, 90, 0}), glm::dvec3(0, 0, 6356752.314245)), 1e-6);
  for (const double lat : {-89.9, -48.0, 0.0, 0.2, 48.76, 90.0})
    for (const double height : {-400.0, 0.0, 9000.0}) {
      const Geodetic back = geodetic_of(geocentric_of({11.42, lat, height}));
      EXPECT_NEAR(back.lat_deg, lat, 1e-11);
      EXPECT_NEAR(back.height_m, height, 1e-6);
    }
}

class EarthTiles : public Tiles {
 protected:
  static constexpr Geodetic kPlace{11.425, 48.765, 370};
  // Turns a local frame at `place` to the earth's: columns east, north, up, origin.
  static std::string on_earth(const Geodetic& place) {
    const glm::dmat4 matrix = glm::inverse(EarthFrame(place).from_geocentric());
    std::ostringstream text;
    text.precision(17);
    text << R"("transform":[)";
    for (int i = 0; i < 16; ++i) text << (i > 0 ? "," : "") << matrix[i / 4][i % 4];
    text << "]";
    return text.str();
  }
  static std::string region(const Geodetic& place, double half_deg, double half_m) {
    std::ostringstream text;
    text.precision(17);
    text << R"("boundingVolume":{"region":[)" << glm::radians(place.lon_deg - half_deg) << ","
         << glm::radians(place.lat_deg - half_deg) << "," << glm::radians(place.lon_deg + half_deg) << ","
         << glm::radians(place.lat_deg + half_deg) << "," << place.height_m - half_m << "," << place.height_m + half_m
         << R"(]},"geometricError":0)";
    return text.str();
  }
  static void expect_flat_at(const Scene& scene, std::size_t first, const glm::dvec3& corner, double tolerance_m) {
    EXPECT_LT(glm::distance(scene.positions[first], corner), tolerance_m);
    EXPECT_LT(glm::distance(scene.positions[first + 1], corner + glm::dvec3(0, -2, 0)), tolerance_m);
    EXPECT_LT(glm::distance(scene.positions[first + 2], corner + glm::dvec3(2, 0, 0)), tolerance_m);
  }
};

TEST_F(EarthTiles, RegionsGiveALocalFrameThatIsFlatAndUpright) {
  write("a.glb", model());
  const Scene scene =
      shown(tileset("{" + region(kPlace, 0.01, 20) + "," + on_earth(kPlace) + "," + content("a.glb") + "}"));
  ASSERT_EQ(scene.positions.size(), 3U);
  expect_flat_at(scene, 0, glm::dvec3(0), 1e-7);
  EXPECT_EQ(scene.crs, "ENU of EPSG:4978 at lon 11.4250000, lat 48.7650000, h 370.000 m");
  // Across 180 degrees, where west is greater than east.
  const Geodetic fiji{180, -16.5, 0};
  const Scene far =
      shown(tileset(R"({"boundingVolume":{"region":[3.1400926535897932,-0.289,-3.1400926535897932,-0.287,0,0]},)" +
                    on_earth(fiji) + "," + content("a.glb") + "}"));
  ASSERT_EQ(far.positions.size(), 3U);
  EXPECT_NEAR(far.positions[0].x, 0, 0.01);
  EXPECT_NEAR(far.positions[0].z, 0, 1);
  EXPECT_GT(normal2(far, 0).z, 3.99);
}

TEST_F(EarthTiles, BoxesNearTheEarthsRadiusDoAsWellAndProjectedNorthingsDoNot) {
  write("a.b3dm", [] {
    std::ostringstream features;
    features.precision(17);
    const glm::dvec3 center = geocentric_of(kPlace);
    features << R"({"RTC_CENTER":[)" << center.x << "," << center.y << "," << center.z << "]}";
    return b3dm(features.str());
  }());
  std::ostringstream sphere;
  sphere.precision(17);
  const glm::dvec3 center = geocentric_of(kPlace);
  sphere << R"({"boundingVolume":{"sphere":[)" << center.x << "," << center.y << "," << center.z
         << R"(,50]},"geometricError":0,)" << content("a.b3dm") << "}";
  // Under a root as wide as the earth, the tile that lies somewhere says where.
  for (const std::string& json : {sphere.str(), tile(R"("children":[)" + sphere.str() + "]"),
                                  "{" + region({0, 0, 0}, 89, 1000) + R"(,"children":[)" + sphere.str() + "]}"}) {
    const Scene scene = shown(tileset(json));
    ASSERT_EQ(scene.positions.size(), 3U);
    EXPECT_LT(glm::length(scene.positions[0]), 0.01);  // the frame's origin is rounded
    EXPECT_EQ(scene.crs, "ENU of EPSG:4978 at lon 11.4250000, lat 48.7650000, h 370.000 m");
  }
  write("a.glb", model());
  const Scene projected = shown(tileset(tile(moved(560000, 6330000, 12) + "," + content("a.glb"))));
  EXPECT_EQ(projected.crs, "");
  EXPECT_EQ(projected.positions[0], glm::dvec3(560000, 6330000, 12));
}

TEST_F(EarthTiles, LaterTilesetsShareTheFirstOnesFrame) {
  write("a.glb", model());
  const Geodetic north{kPlace.lon_deg, kPlace.lat_deg + 0.001, kPlace.height_m};
  const auto text = [&](const Geodetic& place) {
    return tileset("{" + region(place, 0.0001, 1) + "," + on_earth(place) + "," + content("a.glb") + "}");
  };
  const std::array inputs{write("one.json", text(kPlace)), write("two.json", text(north))};
  const auto scene = import_inputs(inputs);
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  ASSERT_EQ(scene->positions.size(), 6U);
  expect_flat_at(*scene, 0, glm::dvec3(0), 1e-7);
  // A thousandth of a degree of a meridian there is 111.2 m.
  EXPECT_NEAR(scene->positions[3].y, 111.2, 0.1);
  EXPECT_NEAR(scene->positions[3].z, 0, 0.002);
  // A world in a system that nobody knows is not mixed in.
  write("world.json", tileset(tile(content("a.glb")), R"("version":"1.1")",
                              R"("extras":{"zonecast_index":"world.zcw","crs":"EPSG:0"},)"));
  const std::array mixed{inputs[0], folder_ / "world.json"};
  const auto refusal = import_inputs(mixed);
  ASSERT_FALSE(refusal.ok());
  EXPECT_NE(refusal.error().message.find("reference system"), std::string::npos);
}

TEST_F(EarthTiles, RegionsOffTheEarthAreRefused) {
  for (const char* numbers : {"0,0,1,1,0", R"(0,0,1,"1",0,0)", "0,50,1,51,0,0", "11,0,12,1,0,0"})
    expect_refused(tileset(std::string(R"({"boundingVolume":{"region":[)") + numbers + "]}}"), "region");
}

}  // namespace
}  // namespace zc::test
