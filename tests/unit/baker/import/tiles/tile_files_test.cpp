// SPDX-License-Identifier: GPL-3.0-or-later
// Where the files of tilesets come from: archives (.3tz), gzipped files, files by themselves, files that are not there;
// and that each is read once, wherever it stands.
#include <map>

#include "tests/unit/baker/import/deflated.h"
#include "tests/unit/baker/import/tiles/tiles_support.h"

namespace zc::test {
namespace {

using Names = std::vector<std::string>;
using Zip = std::vector<ZipEntry>;

class TileFilesTest : public Tiles {
 protected:
  Result<Scene> import_skipping(const std::string& json) const {
    const auto path = write("tileset.json", json);
    return import_inputs(std::span<const std::filesystem::path>(&path, 1), {.skip_missing = true});
  }
};

TEST_F(TileFilesTest, ArchivesAreReadHoweverTheirFilesAreStored) {
  // A glTF whose buffer is a file too, a GLB, and a tileset in a folder.
  std::string bin;
  for (const float value : {0.F, 0.F, 0.F, 0.F, 0.F, 2.F, 2.F, 0.F, 0.F}) append(bin, value);
  const std::string gltf =
      R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0,"name":"text"}],"meshes":[{"primitives":[{"attributes":)"
      R"({"POSITION":0}}]}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],)"
      R"("bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":"a%20b.bin"}]})";
  for (const std::uint16_t method : std::initializer_list<std::uint16_t>{0, 8, 93}) {
    Zip zip;
    zip.push_back(
        {"tileset.json", tileset(tile(R"("contents":[{"uri":"sub/part.json"},{"uri":"m/a.gltf"}])")), 0, method});
    zip.push_back({"sub/part.json", tileset(tile(content("../b.glb"))), 0, 0});
    zip.push_back({"b.glb", model("", "binary"), 0, method});
    zip.push_back({"m/a.gltf", gltf, 0, method});
    zip.push_back({"m/a b.bin", bin, 0, method});
    const auto scene = import(write("a.3tz", zipped(zip)));
    ASSERT_TRUE(scene.ok()) << method << ": " << scene.error().describe();
    EXPECT_EQ(names(*scene), (Names{"binary", "text"})) << method;
  }
}

TEST_F(TileFilesTest, DamagedArchivesAreRefused) {
  Zip zip;
  const std::string json = tileset(tile(content("b.glb")));
  zip.push_back({"tileset.json", json, 0, 8});
  zip.push_back({"b.glb", model(), 0, 8});
  const std::string good = zipped(zip);
  ASSERT_TRUE(import(write("a.3tz", good)).ok());
  for (std::size_t length = 4; length < good.size() - 2; length += 3) {
    const auto scene = import(write("a.3tz", good.substr(0, length)));
    ASSERT_FALSE(scene.ok()) << length;
    EXPECT_EQ(scene.error().describe().find('\n'), std::string::npos);
  }
  std::string flipped = good;
  flipped[good.find("b.glb") + 20] ^= 4;
  EXPECT_FALSE(import(write("a.3tz", flipped)).ok());
  Zip stored;
  stored.push_back({"tileset.json", json, 0, 0});
  stored.push_back({"b.glb", model("", "part"), 0, 0});
  flipped = zipped(stored);
  flipped[flipped.find(R"("part")") + 2] ^= 1;  // still a name
  const auto renamed = import(write("a.3tz", flipped));
  ASSERT_FALSE(renamed.ok());
  EXPECT_NE(renamed.error().message.find("is damaged or cut short"), std::string::npos) << renamed.error().describe();
  Zip other;
  other.push_back({"b.glb", model(), 0, 0});
  EXPECT_TRUE(import(write("a.zip", zipped(other))).ok()) << "models by themselves";
  Zip outside;
  outside.push_back({"tileset.json", tileset(tile(content("../b.glb"))), 0, 0});
  EXPECT_FALSE(import(write("a.3tz", zipped(outside))).ok());
  Zip strange;
  strange.push_back({"tileset.json", json, 0, 14});
  const auto method = import(write("a.3tz", zipped(strange)));
  ASSERT_FALSE(method.ok());
  EXPECT_NE(method.error().message.find("method 14"), std::string::npos) << method.error().describe();
}

TEST_F(TileFilesTest, GzippedFilesAreUnpacked) {
  write("a.glb", gzipped(model("", "first")));
  write("b.b3dm", gzipped(b3dm("")) + gzipped(""));
  write("part.json", gzipped(tileset(tile(content("b.b3dm")))));
  const auto scene =
      import(write("tileset.json", gzipped(tileset(tile(R"("contents":[{"uri":"a.glb"},{"uri":"part.json"}])")))));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  EXPECT_EQ(names(*scene), (Names{"first", "part"}));
  // Cut short, damaged, and far longer than it looks.
  const std::string good = gzipped(model());
  const std::string json = tileset(tile(content("a.glb")));
  write("a.glb", good.substr(0, good.size() / 2));
  expect_refused(json, "ends early", "a.glb");
  std::string damaged = good;
  damaged[good.size() - 6] ^= 1;  // of the checksum
  write("a.glb", damaged);
  expect_refused(json, "damaged", "a.glb");
  std::string bomb;
  const std::string member = gzipped(std::string(1U << 20U, ' '));
  for (int i = 0; i < 300; ++i) bomb += member;
  write("a.glb", bomb);
  expect_refused(json, "more than the 268435456 bytes", "a.glb");
}

TEST_F(TileFilesTest, TilesetsThatTakeFarMoreMemoryThanTheirTextAreRefused) {
  std::string lists = R"({"asset":{"version":"1.1"},"geometricError":1,"root":{},"extras":[0)";
  for (int i = 0; i < (1 << 23); ++i) lists += ",[]";
  const auto scene = import(write("tileset.json", lists + "]}"));
  ASSERT_FALSE(scene.ok());
  EXPECT_NE(scene.error().message.find("more than the 512 allowed"), std::string::npos) << scene.error().describe();
}

TEST_F(TileFilesTest, ATilesContentIsAnInputByItself) {
  write("m.glb", model());
  std::string position;
  for (const float value : {1.F, 2.F, 3.F}) append(position, value);
  const std::string instance = i3dm(R"({"INSTANCES_LENGTH":1,"POSITION":{"byteOffset":0}})", position, "m.glb", 0);
  for (const auto& [name, bytes] :
       std::map<std::string, std::string>{{"a.b3dm", b3dm(R"({"RTC_CENTER":[1,2,3]})")},
                                          {"a.cmpt", packed("cmpt", b3dm(R"({"RTC_CENTER":[1,2,3]})"), {1})},
                                          {"a.i3dm", instance},
                                          {"a.b3dm.gz", gzipped(b3dm(R"({"RTC_CENTER":[1,2,3]})"))}}) {
    const auto scene = import(write(name, bytes));
    ASSERT_TRUE(scene.ok()) << name << ": " << scene.error().describe();
    EXPECT_EQ(scene->positions.at(0), glm::dvec3(1, 2, 3)) << name;
  }
  const auto points = import(write("a.pnts", packed("pnts", "", {0, 0, 0, 0})));
  ASSERT_FALSE(points.ok());
  EXPECT_EQ(points.error().message,
            "has no triangles, expected city objects, meshes or tiles with surfaces; found: tile contents of kind pnts "
            "(points), left out: 1");
}

TEST_F(TileFilesTest, WhatIsNotThereIsNamedAndMayBeSkipped) {
  write("a.glb", model());
  write("c.gltf", R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":36,"uri":"none.bin"}]})");
  const std::string json = tileset(tile(
      R"("refine":"ADD","contents":[{"uri":"none.glb"},{"uri":"a.glb"},{"uri":"none.json"},{"uri":"c.gltf"}],"children":[)" +
      tile(R"("content":{"uri":"x{x}.glb"},"implicitTiling":{"subdivisionScheme":"QUADTREE","availableLevels":1,)"
           R"("subtreeLevels":1,"subtrees":{"uri":"none.subtree"}})") +
      "]"));
  expect_refused(json, "--skip-missing", "none.subtree");
  const auto scene = import_skipping(json);
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  EXPECT_EQ(names(*scene), Names{"part"});
  ASSERT_EQ(scene->notes.size(), 1U);
  EXPECT_TRUE(scene->notes[0].is_missing);
  EXPECT_EQ(scene->notes[0].count, 4U);
  Names missing;
  for (const std::string& name : scene->notes[0].names) missing.push_back(std::filesystem::path(name).filename());
  EXPECT_EQ(missing, (Names{"none.subtree", "none.json", "none.glb", "none.bin"}));
  // A damaged file is there.
  write("a.glb", "glTF");
  EXPECT_FALSE(import_skipping(json).ok());
}

TEST_F(TileFilesTest, TilesetsThatNameEachOtherTwiceAreReadOnce) {
  write("a.glb", model());
  const auto twice = [&](const auto& first, const auto& second) {
    for (int i = 0; i < 30; ++i) {
      const std::string next = i == 29 ? "a.glb" : std::to_string(i + 1) + ".json";
      write(std::to_string(i) + ".json",
            tileset(tile(R"("refine":"ADD","children":[)" + tile(first(i) + content(next)) + "," +
                         tile(second(i) + content(next)) + "]")));
    }
    return import(folder_ / "0.json");
  };
  const auto nowhere = [](int) { return std::string(); };
  const auto same = twice(nowhere, nowhere);
  ASSERT_TRUE(same.ok()) << same.error().describe();
  EXPECT_EQ(names(*same), Names{"part"});
  // Where they stand elsewhere each time, there are 2^30.
  const auto moving = twice(nowhere, [](int i) { return moved(1 << i, 0, 0) + ","; });
  ASSERT_FALSE(moving.ok());
  EXPECT_NE(moving.error().message.find("more than 262144 external tilesets"), std::string::npos)
      << moving.error().describe();
}

TEST_F(TileFilesTest, RepeatedContentsStandAtEachOfTheirPlaces) {
  write("a.glb", model());
  write("sub.json", tileset(tile(content("a.glb"))));
  const std::string mirror = R"("transform":[-1,0,0,0,0,1,0,0,0,0,1,0,50,0,0,1],)";
  const Scene scene = shown(
      tileset(tile(R"("refine":"ADD","children":[)" + tile(moved(10, 0, 0) + "," + content("sub.json")) + "," +
                   tile(moved(20, 0, 0) + "," + content("sub.json")) + "," +
                   tile(moved(10, 0, 0) + "," + content("sub.json")) + "," + tile(mirror + content("a.glb")) + "]")));
  ASSERT_EQ(scene.positions.size(), 9U);
  EXPECT_EQ(scene.positions[0], glm::dvec3(10, 0, 0));
  EXPECT_EQ(scene.positions[3], glm::dvec3(20, 0, 0));
  EXPECT_EQ(scene.positions[6], glm::dvec3(50, 0, 0));
  for (std::size_t t = 0; t < 3; ++t) EXPECT_GT(normal2(scene, t).z, 0) << t;
}

}  // namespace
}  // namespace zc::test
