// SPDX-License-Identifier: GPL-3.0-or-later
// Inputs that are more than one plain file: folders, gzip, ZIP archives.
#include "tests/unit/baker/import/deflated.h"
#include "tests/unit/baker/import/import_support.h"
#include "tests/unit/counted_memory.h"

namespace zc::test {
namespace {

class Inputs : public ImportTest {
 protected:
  // A square of `side` metres with the texture wall.png.
  static std::string house(const std::string& id, int side) {
    const std::string s = std::to_string(side);
    const std::string points = "0 0 0 " + s + " 0 0 " + s + " " + s + " 0 0 " + s + " 0 0 0 0";
    return "<CityModel xmlns=\"http://www.opengis.net/citygml/2.0\" xmlns:gml=\"http://www.opengis.net/gml\" "
           "xmlns:app=\"http://www.opengis.net/citygml/appearance/2.0\"><app:appearanceMember><app:Appearance>"
           "<app:surfaceDataMember><app:ParameterizedTexture><app:imageURI>textures/wall.png</app:imageURI>"
           "<app:target uri=\"#p\"><app:TexCoordList><app:textureCoordinates ring=\"#r\">0 0 1 0 1 1 0 1 0 0"
           "</app:textureCoordinates></app:TexCoordList></app:target></app:ParameterizedTexture>"
           "</app:surfaceDataMember></app:Appearance></app:appearanceMember><cityObjectMember><Building gml:id=\"" +
           id +
           "\"><lod2MultiSurface><gml:Polygon gml:id=\"p\"><gml:exterior><gml:LinearRing gml:id=\"r\"><gml:posList>" +
           points +
           "</gml:posList></gml:LinearRing></gml:exterior></gml:Polygon></lod2MultiSurface></Building>"
           "</cityObjectMember></CityModel>";
  }
  static std::string sequence(int side) {
    const std::string s = std::to_string(side);
    return R"({"type":"CityJSON","version":"2.0","transform":{"scale":[1,1,1],"translate":[0,0,0]},)"
           R"("CityObjects":{},"vertices":[]})"
           "\n"
           R"({"type":"CityJSONFeature","id":"f","CityObjects":{"f":{"type":"Building","geometry":[)"
           R"({"type":"MultiSurface","lod":"2","boundaries":[[[0,1,2,3]]]}]}},"vertices":[[0,0,0],[)" +
           s + ",0,0],[" + s + "," + s + ",0],[0," + s + ",0]]}\n";
  }
  static std::string image() {
    return {
        "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x02\0\0\0\x01\x08\x02\0\0\0\x7b\x40\xe8\xdd"
        "\0\0\0\x0fIDATx\x9c\x63\x60\x60\x60\xf8\xff\xff\x3f\0\x06\x01\x02\xfe\x02\xb2\x39\xae"
        "\0\0\0\0IEND\xae\x42\x60\x82",
        72};
  }
  static std::vector<std::string> ids(const Scene& scene) {
    std::vector<std::string> found;
    for (const SceneObject& object : scene.objects) found.push_back(object.id);
    return found;
  }
  using Ids = std::vector<std::string>;

  void refused(const std::filesystem::path& path, const std::string& place, const std::string& words) const {
    const auto scene = import(path);
    ASSERT_FALSE(scene.ok()) << words;
    EXPECT_NE(scene.error().message.find(words), std::string::npos) << scene.error().describe();
    EXPECT_EQ(scene.error().path, (folder_ / place).string());
    EXPECT_EQ(scene.error().describe().find('\n'), std::string::npos);
  }
};

TEST_F(Inputs, GzippedModelsAreWhatTheyWerePackedFrom) {
  std::filesystem::create_directory(folder_ / "textures");
  write("textures/wall.png", image());
  const std::string text = house("a", 4);
  // Two members, as `cat a.gz b.gz` makes them.
  for (const std::string& packed : {gzipped(text), gzipped(text.substr(0, 99)) + gzipped(text.substr(99))}) {
    const auto scene = import(write("house.gml.gz", packed));
    ASSERT_TRUE(scene.ok()) << scene.error().describe();
    EXPECT_EQ(area(*scene), 16);
    EXPECT_EQ(scene->texcoords.size(), 2U);
    EXPECT_EQ(scene->images.size(), 1U);
  }
  const auto lines = import(write("city.city.jsonl.gz", gzipped(sequence(3))));
  ASSERT_TRUE(lines.ok()) << lines.error().describe();
  EXPECT_EQ(area(*lines), 9);

  const std::string packed = gzipped(text);
  refused(write("cut.gml.gz", packed.substr(0, packed.size() / 2)), "cut.gml.gz", "ends early");
  std::string damaged = packed;
  damaged[packed.size() / 2] = static_cast<char>(damaged[packed.size() / 2] ^ 0x55);
  EXPECT_FALSE(import(write("damaged.gml.gz", damaged)).ok());
  refused(write("noise.gz", gzipped("noise")), "noise.gz", "of no format that is read");
}

TEST_F(Inputs, WhatIsPackedToFillMemoryIsRefusedBeforeItDoes) {
  const std::string bomb(std::size_t{64} << 20U, ' ');
  const std::string member = gzipped(bomb);
  std::string gzip_bomb;
  for (int i = 0; i < 16; ++i) gzip_bomb += member;
  const std::string zip_bomb = zipped({{"bomb.gml", bomb}});
  const auto bombs = [&] {
    refused(write("bomb.gml.gz", gzip_bomb), "bomb.gml.gz", "unpacks to more than");
    refused(write("bomb.zip", zip_bomb), "bomb.zip/bomb.gml", "unpacks to more than");
  };
  EXPECT_LT(test::most_memory_of(bombs), 40 << 20);

  // Many files that are each within their bounds share one run of bytes: all together are not.
  const std::string half(std::size_t{9} << 20U, ' ');
  refused(write("shared.zip", zipped({{"a.gml", "<CityModel/>" + half}, {"b.gml", "<CityModel/>" + half}})),
          "shared.zip", "unpacks to more than");
  // A size that is declared too small.
  std::string small = zipped({{"a.gml", house("a", 4)}});
  const std::size_t directory = small.rfind("PK\x01\x02");
  small[directory + 24] = 1;
  small[directory + 25] = 0;
  refused(write("small.zip", small), "small.zip/a.gml", "damaged or cut short");
}

TEST_F(Inputs, ArchivesGiveTheirModelsWithTheirImages) {
  const auto path = write("city.zip", zipped({{"tiles/b.gml", house("b", 3)},
                                              {"tiles\\textures\\wall.png", image(), 0, 0},
                                              {"tiles/a.GML", house("a", 4)},
                                              {"codelists/roof.xml", "<!-- <CityModel> --><Dictionary/>"},
                                              {"metadata.json", R"({"title":"a city"})"},
                                              {"__MACOSX/tiles/._a.gml", "\x01\x02"},
                                              {"../outside.gml", "<"},
                                              {"readme.txt", "hello"}}));
  const auto scene = import(path);
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  EXPECT_EQ(ids(*scene), (Ids{"a", "b"}));
  EXPECT_EQ(scene->images.size(), 1U);
  EXPECT_EQ(scene->texcoords.size(), 4U);
  EXPECT_EQ(noted(*scene, "no city models"), 2U);

  const std::string painted =
      R"({"type":"CityJSON","version":"2.0","transform":{"scale":[1,1,1],"translate":[0,0,0]},"appearance":{"textures":)"
      R"([{"type":"PNG","image":"textures/wall.png"}],"vertices-texture":[[0,0],[1,0],[1,1]]},"CityObjects":{"c":{)"
      R"("type":"Building","geometry":[{"type":"MultiSurface","lod":"2","boundaries":[[[0,1,2]]],"texture":{"t":{)"
      R"("values":[[[0,0,1,2]]]}}}]}},"vertices":[[0,0,0],[4,0,0],[0,4,0]]})";
  const auto json = import(write("json.zip", zipped({{"c.json", painted}, {"textures/wall.png", image()}})));
  ASSERT_TRUE(json.ok()) << json.error().describe();
  EXPECT_EQ(json->texcoords.size(), 1U);

  const auto zstandard = import(write("zstd.zip", zipped({{"a.gml", house("a", 4), 0, 93}})));
  ASSERT_TRUE(zstandard.ok()) << zstandard.error().describe();
  EXPECT_EQ(area(*zstandard), 16);
  refused(write("secret.zip", zipped({{"a.gml", house("a", 4), 1}})), "secret.zip/a.gml", "is encrypted");
  refused(write("other.zip", zipped({{"a.gml", house("a", 4), 0, 14}})), "other.zip/a.gml", "compressed by method 14");
  refused(write("twice.zip", zipped({{"a.gml.gz", gzipped(house("a", 4))}})), "twice.zip/a.gml.gz", "packed once more");
  refused(write("none.zip", zipped({{"readme.txt", "hello"}})), "none.zip", "an archive without city models");
  refused(write("broken.zip", zipped({{"a.gml", house("a", 4) + "<"}})), "broken.zip/a.gml", "invalid XML");
  const std::string whole = zipped({{"a.gml", house("a", 4)}});
  for (std::size_t i = 0; i < whole.size(); i += 11) {
    const auto cut = import(write("cut.zip", whole.substr(0, i)));
    EXPECT_FALSE(cut.ok()) << i;
    std::string changed = whole;
    changed[i] = static_cast<char>(changed[i] ^ 0x11);
    if (const auto other = import(write("changed.zip", changed)); other.ok()) expect_whole(*other);
  }
}

TEST_F(Inputs, FoldersAreTheirModelsInTheOrderOfTheirPaths) {
  for (const char* folder : {"city", "city/north", "city/north/textures", "city/.hidden", "city/world", "none"})
    std::filesystem::create_directory(folder_ / folder);
  write("city/north/z.gml", house("z", 2));
  write("city/north/textures/wall.png", image());
  write("city/a.zip", zipped({{"m.gml", house("m", 2)}, {"n.gml", house("n", 2)}}));
  write("city/b.gml.gz", gzipped(house("b", 2)));
  write("city/c.jsonl", sequence(2));
  write("city/list.xml", "<Dictionary>");
  write("city/log.jsonl", "{\"a\":1}\n{\"b\":2}\n");
  write("city/.hidden/x.gml", "<");
  write("city/world/world.zcw", "baked before");
  write("city/world/tileset.json", "{}");
  const auto scene = import(folder_ / "city");
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  EXPECT_EQ(ids(*scene), (Ids{"m", "n", "b", "f", "z"}));
  EXPECT_EQ(noted(*scene, "no city models"), 2U);
  EXPECT_EQ(noted(*scene, "missing texture images"), 2U);  // beside a.zip's models, and beside b

  refused(folder_ / "none", "none", "a folder without city models");
  write("city/north/y.gml", house("y", 2) + "<");
  refused(folder_ / "city", "city/north/y.gml", "invalid XML");
  write("none/list.xml", "<Dictionary/>");
  refused(folder_ / "none", "none", "found: files in folders and archives that are no city models, left out: 1");
}

TEST_F(Inputs, AFolderWithATilesetIsThatTileset) {
  write("tileset.json", R"({"asset":{"version":"1.1"},"geometricError":1,"root":{"geometricError":0,)"
                        R"("boundingVolume":{"sphere":[0,0,0,1]},"content":{"uri":"none.glb"}}})");
  write("a.gml", house("a", 4));
  const auto scene = import(folder_);
  ASSERT_FALSE(scene.ok());
  EXPECT_NE(scene.error().path.find("none.glb"), std::string::npos) << scene.error().describe();
}

}  // namespace
}  // namespace zc::test
