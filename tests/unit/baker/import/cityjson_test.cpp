// SPDX-License-Identifier: GPL-3.0-or-later
#include <chrono>

#include "tests/unit/baker/import/import_support.h"

namespace zc::test {
namespace {

class CityJson : public ImportTest {
 protected:
  static std::string document(const std::string& objects, const std::string& vertices, const std::string& more = "") {
    return R"({"type":"CityJSON","version":"2.0","transform":{"scale":[0.5,0.5,0.5],"translate":[1000000,2000000,10]},)"
           R"("metadata":{"referenceSystem":"https://www.opengis.net/def/crs/EPSG/0/7415"},)" +
           more + R"("CityObjects":{)" + objects + R"(},"vertices":)" + vertices + "}";
  }
  // A cube of 1 m, outward, in half metres.
  static constexpr const char* kCubeVertices = "[[0,0,0],[2,0,0],[2,2,0],[0,2,0],[0,0,2],[2,0,2],[2,2,2],[0,2,2]]";
  static std::string cube_shell() {
    return "[[[0,3,2,1]],[[4,5,6,7]],[[0,1,5,4]],[[1,2,6,5]],[[2,3,7,6]],[[3,0,4,7]]]";
  }
  static std::string cube(const std::string& id, const std::string& lod = "2", const std::string& more = "") {
    return "\"" + id + R"(":{"type":"Building",)" + more + R"("geometry":[{"type":"Solid","lod":")" + lod +
           R"(","boundaries":[)" + cube_shell() + "]}]}";
  }
  static std::string surface(const std::string& rings) {
    return R"("a":{"type":"LandUse","geometry":[{"type":"MultiSurface","lod":"1","boundaries":[)" + rings + "]}]}";
  }
};

TEST_F(CityJson, CubeBecomesTwelveOutwardTrianglesInItsCrs) {
  const auto scene = import_text("cube.json", document(cube("house"), kCubeVertices));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  expect_whole(*scene);
  EXPECT_EQ(scene->triangles.size(), 12U);
  EXPECT_EQ(scene->positions.size(), 8U);
  EXPECT_DOUBLE_EQ(volume(*scene), 1.0);
  EXPECT_EQ(scene->positions.front(), glm::dvec3(1000000, 2000000, 10));
  EXPECT_EQ(scene->crs, "https://www.opengis.net/def/crs/EPSG/0/7415");
  ASSERT_EQ(scene->objects.size(), 1U);
  EXPECT_EQ(scene->objects[0].id, "house");
  EXPECT_EQ(scene->objects[0].kind, ObjectKind::kObject);
  EXPECT_EQ(scene->materials.size(), 3U);  // ground, roof, wall by the way they face
  EXPECT_TRUE(scene->notes.empty());
}

TEST_F(CityJson, PolygonWithHoleHasItsArea) {
  const auto scene =
      import_text("hole.json", document(surface("[[0,1,2,3],[4,5,6,7]]"),
                                        "[[0,0,0],[20,0,0],[20,20,0],[0,20,0],[6,6,0],[6,10,0],[10,10,0],[10,6,0]]"));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  EXPECT_DOUBLE_EQ(area(*scene), 100.0 - 4.0);
  for (std::size_t t = 0; t < scene->triangles.size(); ++t) EXPECT_GT(normal2(*scene, t).z, 0);
  EXPECT_EQ(scene->positions.size(), 8U);
  EXPECT_EQ(scene->objects[0].kind, ObjectKind::kGround);
}

TEST_F(CityJson, HoleBridgedIntoItsRingHasTheSameArea) {
  const auto scene = import_text("keyhole.json",
                                 document(surface("[[0,1,2,3,0,4,5,6,7,4]]"),
                                          "[[0,0,0],[20,0,0],[20,20,0],[0,20,0],[6,6,0],[6,10,0],[10,10,0],[10,6,0]]"));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  EXPECT_DOUBLE_EQ(area(*scene), 100.0 - 4.0);
  EXPECT_EQ(noted(*scene, "crossing"), 0U);
}

TEST_F(CityJson, ConcaveTiltedPolygonKeepsAreaAndOrientation) {
  // An L of 3 m² in the plane z = y, corners doubled and on straight edges.
  const auto scene = import_text("l.json", document(surface("[[0,0,1,2,3,4,4,5,6]]"),
                                                    "[[0,0,0],[2,0,0],[4,0,0],[4,2,2],[2,2,2],[2,4,4],[0,4,4]]"));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  EXPECT_NEAR(area(*scene), 3 * std::sqrt(2.0), 1e-9);
  for (std::size_t t = 0; t < scene->triangles.size(); ++t) EXPECT_GT(normal2(*scene, t).z, 0);
}

TEST_F(CityJson, CrossingAndFlatPolygonsAreCountedNotFatal) {
  const auto scene =
      import_text("odd.json", document(surface("[[0,1,2,3]],[[0,2,1,3,4]],[[0,1]],[[0,1,0]],[[0,5,1]],[]"),
                                       "[[0,0,0],[4,0,0],[4,4,0],[0,4,0],[-1,2,0],[2,0,0]]"));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  expect_whole(*scene);
  EXPECT_EQ(noted(*scene, "without area"), 4U);
  EXPECT_EQ(scene->notes[0].names, std::vector{(folder_ / "odd.json").string() + ": 'a'"});
  EXPECT_EQ(noted(*scene, "cross themselves"), 1U);
}

TEST_F(CityJson, RingsThatCrossThemselvesAreCutIntoTheirPieces) {
  // Two triangles of 50 m² each that go round opposite ways; then a ring that goes round twice as much one way.
  for (const auto& [rings, area_m2] : {std::pair{"[[0,1,2,3]]", 100.0}, {"[[0,1,4,5,2,3]]", 200.0}}) {
    const auto scene =
        import_text("bow.json", document(surface(rings), "[[0,0,0],[40,20,0],[40,0,0],[0,20,0],[60,20,0],[60,0,0]]"));
    ASSERT_TRUE(scene.ok()) << scene.error().describe();
    expect_whole(*scene);
    EXPECT_EQ(noted(*scene, "cross themselves, cut into their pieces"), 1U);
    EXPECT_EQ(scene->notes.size(), 1U);
    EXPECT_NEAR(area(*scene), area_m2, 1e-9) << rings;
    for (std::size_t t = 1; t < scene->triangles.size(); ++t)
      EXPECT_GT(glm::dot(normal2(*scene, t), normal2(*scene, 0)), 0);
  }
}

TEST_F(CityJson, HolesMayTouchNestRepeatAndLieOutside) {
  // The ring of 10 m; holes of 2 m: at 2, beside it along half an edge, at 6, within the first, outside.
  const std::string vertices =
      "[[0,0,0],[20,0,0],[20,20,0],[0,20,0],[4,4,0],[4,8,0],[8,8,0],[8,4,0],[8,6,0],[8,10,0],[12,10,0],[12,6,0],"
      "[12,12,0],[12,16,0],[16,16,0],[16,12,0],[5,5,0],[5,7,0],[7,7,0],[7,5,0],[30,0,0],[30,4,0],[34,4,0],[34,0,0],"
      "[6,6,0],[6,10,0],[10,10,0],[10,6,0],[-2,-2,0],[-2,24,0],[24,24,0],[24,-2,0]]";
  const std::string ring = "[0,1,2,3]", first = ",[4,5,6,7]", beside = ",[8,9,10,11]", far = ",[12,13,14,15]";
  const std::string within = ",[16,17,18,19]", outside = ",[20,21,22,23]", across = ",[24,25,26,27]";
  struct Case {
    std::string holes;
    double area_m2;
    std::uint64_t filled;
  };
  for (const auto& [holes, area_m2, filled] :
       {Case{first, 96, 0}, Case{first + beside, 92, 0}, Case{first + first, 96, 0}, Case{first + within, 96, 0},
        Case{within + first, 96, 0}, Case{first + outside, 96, 0}, Case{first + across, 96, 1},
        Case{first + across + far, 92, 1}, Case{first + beside + far + within + outside + far, 88, 0}}) {
    const auto scene = import_text("holes.json", document(surface("[" + ring + holes + "]"), vertices));
    ASSERT_TRUE(scene.ok()) << scene.error().describe();
    EXPECT_NEAR(area(*scene), area_m2, 1e-9) << holes;
    EXPECT_EQ(noted(*scene, "holes that cross another ring, filled"), filled) << holes;
    for (std::size_t t = 0; t < scene->triangles.size(); ++t) EXPECT_GT(normal2(*scene, t).z, 0) << holes;
  }
  for (const char* hole : {",[0,1,2,3]", ",[28,29,30,31]"}) {  // nothing is left of it
    const auto scene = import_text("covered.json", document(surface("[" + ring + hole + "],[[4,5,6,7]]"), vertices));
    ASSERT_TRUE(scene.ok()) << scene.error().describe();
    EXPECT_EQ(noted(*scene, "that their holes cover"), 1U) << hole;
  }
}

TEST_F(CityJson, EveryKindOfLossIsCounted) {
  const auto faces = [](const std::string& labels) {
    return document(R"("a":{"type":"Building","geometry":[{"type":"MultiSurface","lod":"2","boundaries":)" +
                        cube_shell() + labels + "}]}",
                    kCubeVertices, R"("appearance":{"materials":[{"name":"red","diffuseColor":[1,0,0]}]},)");
  };
  const auto expect_noted = [&](const std::string& text, const char* words, std::uint64_t count) {
    const auto scene = import_text("loss.json", text);
    ASSERT_TRUE(scene.ok()) << scene.error().describe();
    EXPECT_EQ(noted(*scene, words), count) << words;
    EXPECT_EQ(scene->notes.size(), 1U) << words;
  };
  expect_noted(faces(R"(,"material":{"m":{"values":[0]}})"), "behind the last material value", 5);
  expect_noted(faces(R"(,"texture":{"m":{"values":[[[null]],[[null]]]}})"), "behind the last texture value", 4);
  expect_noted(faces(R"(,"semantics":{"surfaces":[{"type":"RoofSurface"}],"values":[0,0,0]})"),
               "behind the last semantic value", 3);
  expect_noted(faces(R"(,"material":{"m":{"value":0},"n":{"value":0},"o":{"value":0}})"), "material themes besides", 2);
  // A corner as far as the sun's other side.
  std::string far = faces("");
  far.replace(far.find("[0,0,0],[2,0,0]"), 7, "[1e16,0,0]");
  expect_noted(far, "out of range", 3);
}

TEST_F(CityJson, VertexIndexOutOfRangeNamesObjectIndexAndPlace) {
  const std::string text = document(surface("[[0,1,99]]"), "[[0,0,0],[4,0,0],[4,4,0]]");
  const auto scene = import_text("bad.json", text);
  ASSERT_FALSE(scene.ok());
  EXPECT_EQ(scene.error().code, ErrorCode::kFormat);
  EXPECT_NE(scene.error().message.find("'a'"), std::string::npos);
  EXPECT_NE(scene.error().message.find("99"), std::string::npos);
  EXPECT_EQ(scene.error().byte_offset, static_cast<std::int64_t>(text.find("\"a\"")));
  EXPECT_NE(scene.error().path.find("bad.json"), std::string::npos);
}

TEST_F(CityJson, EveryTruncationIsAnErrorOfOneLine) {
  const std::string text = document(cube("house"), kCubeVertices);
  for (std::size_t length = 0; length < text.size(); ++length) {
    const auto scene = import_text("cut.json", std::string_view(text).substr(0, length));
    ASSERT_FALSE(scene.ok()) << length;
    EXPECT_EQ(scene.error().message.find('\n'), std::string::npos);
  }
}

TEST_F(CityJson, EveryChangedByteEndsWithoutACrash) {
  const std::string text = document(cube("house"), kCubeVertices);
  for (std::size_t at = 0; at < text.size(); ++at)
    for (const char value : {'\0', '9', '"', '['}) {
      std::string changed = text;
      changed[at] = value;
      const auto scene = import_text("changed.json", changed);
      if (scene.ok()) expect_whole(*scene);
    }
}

TEST_F(CityJson, WrongValuesAreErrors) {
  const auto fails = [&](std::string text, std::string_view from, std::string_view to) {
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    const auto scene = import_text("wrong.json", text);
    EXPECT_FALSE(scene.ok()) << to;
  };
  const std::string good = document(cube("house"), kCubeVertices);
  fails(good, R"("type":"CityJSON")", R"("type":"CityGML")");
  fails(good, R"("version":"2.0")", R"("version":"1.0")");
  fails(good, R"("version":"2.0")", R"("version":2.0)");
  fails(good, "[0.5,0.5,0.5]", "[0.5,0.5]");
  fails(good, "[0.5,0.5,0.5]", R"("0.5")");
  fails(good, "[0.5,0.5,0.5]", "[0.5,1e308,0.5]");
  fails(good, "[2,0,0]", "[2,0,\"0\"]");
  fails(good, "[2,0,0]", "[2,1e999,0]");
  fails(good, "[2,0,0]", "7");
  fails(good, "[0,3,2,1]", "[0,3,2,-1]");
  fails(good, "[0,3,2,1]", "[0,3,2,1.5]");
  fails(good, "[0,3,2,1]", "{\"0\":1}");
  fails(good, "[0,3,2,1]", "3");
  fails(good, R"("Solid")", R"("Sphere")");
  fails(good, R"("Solid")", R"("MultiSolid")");
  fails(good, R"("lod":"2")", R"("lod":"two")");
  fails(good, R"("lod":"2")", R"("lod":[2])");
  fails(good, R"({"type":"Building")", R"({"type":[1])");
  fails(good, R"("house":)", R"("house":3,"other":)");
  fails(good, R"("geometry":[)", R"("geometry":3,"g":[)");
  fails(good, R"("https)", R"(3,"x":"https)");
  fails(document("", "[]"), "CityJSON", "CityJSON");  // nothing in it
  EXPECT_FALSE(import_text("deep.json", R"({"type":"CityJSON","version":"2.0","x":)" + std::string(200000, '[')).ok());
}

TEST_F(CityJson, HighestLevelOfDetailCounts) {
  const std::string objects =
      R"("a":{"type":"Building","geometry":[{"type":"MultiSurface","lod":"10","boundaries":[[[0,1,2]]]},)"
      R"({"type":"Solid","lod":"2.2","boundaries":[)" +
      cube_shell() + R"(]},{"type":"MultiPoint","lod":"11","boundaries":[0]}]})";
  const auto scene = import_text("lod.json", document(objects, kCubeVertices));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  EXPECT_EQ(scene->triangles.size(), 1U);
  EXPECT_EQ(noted(*scene, "points or lines"), 1U);
}

TEST_F(CityJson, ChildrenJoinTheirParentAtItsLevelAndReplaceItsFootprint) {
  const std::string footprint =
      R"("f":{"type":"Building","children":["fp"],"geometry":[{"type":"MultiSurface","lod":"0","boundaries":[[[0,1,2,3]]]}]},)";
  const auto scene = import_text("family.json", document(cube("a") + "," + cube("b", "2", R"("parents":["a"],)") + "," +
                                                             cube("c", "1", R"("parents":["a"],)") + "," + footprint +
                                                             cube("fp", "2", R"("parents":["f"],)"),
                                                         kCubeVertices));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  expect_whole(*scene);
  ASSERT_EQ(scene->objects.size(), 3U);
  EXPECT_EQ(scene->objects[0].id, "a");
  EXPECT_EQ(scene->objects[0].triangle_count, 24U);
  EXPECT_EQ(scene->objects[1].id, "c");
  EXPECT_EQ(scene->objects[2].id, "fp");
}

TEST_F(CityJson, LongChainsAndCirclesOfParentsEnd) {
  const auto object = [](int i, int parent) {
    std::string text =
        "\"o" + std::to_string(100'000 + i) +
        R"(":{"type":"BuildingPart","geometry":[{"type":"MultiSurface","lod":"2","boundaries":[[[0,1,2]]]}])";
    if (parent >= 0) text += R"(,"parents":["o)" + std::to_string(100'000 + parent) + "\"]";
    return text + "}";
  };
  const auto document = [](const std::string& objects) {
    return R"({"type":"CityJSON","version":"2.0","transform":{"scale":[1,1,1],"translate":[0,0,0]},"CityObjects":{)" +
           objects + R"(},"vertices":[[0,0,0],[4,0,0],[0,4,0]]})";
  };
  for (const bool downwards : {false, true}) {
    const int count = 20'000;
    std::string objects = downwards ? object(count - 1, -1) : object(0, -1);
    for (int i = 1; i < count; ++i) objects += "," + (downwards ? object(count - 1 - i, count - i) : object(i, i - 1));
    const auto begin = std::chrono::steady_clock::now();
    const auto scene = import_text("chain.json", document(objects));
    ASSERT_TRUE(scene.ok()) << scene.error().describe();
    ASSERT_EQ(scene->objects.size(), 1U);
    EXPECT_EQ(scene->objects[0].id, downwards ? "o119999" : "o100000");
    EXPECT_EQ(scene->triangles.size(), 20'000U);
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
  }
  // 1 and 2 name each other, 0 and 3 lead to them: each stays an object of its own.
  const auto circle =
      import_text("circle.json", document(object(0, 1) + "," + object(1, 2) + "," + object(2, 1) + "," + object(3, 2)));
  ASSERT_TRUE(circle.ok()) << circle.error().describe();
  EXPECT_EQ(circle->objects.size(), 4U);
}

TEST_F(CityJson, SemanticsDecideMaterialsAndOpenClosuresGo) {
  const std::string objects =
      R"("a":{"type":"Building","geometry":[{"type":"MultiSurface","lod":"3","boundaries":[[[0,1,5]],[[1,2,6]],[[2,3,7]],[[4,5,6]]],)"
      R"("semantics":{"surfaces":[{"type":"Window"},{"type":"Door"},{"type":"ClosureSurface"}],"values":[0,1,2,null]}}]})";
  const auto scene = import_text("semantic.json", document(objects, kCubeVertices));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  ASSERT_EQ(scene->triangles.size(), 3U);
  const auto material = [&](std::size_t t) { return scene->materials[scene->triangle_material[t]]; };
  EXPECT_EQ(material(0).name, "Window");
  EXPECT_FLOAT_EQ(material(0).roughness, 0.03F);
  EXPECT_EQ(material(1).name, "Door");
  EXPECT_TRUE(material(2).name.starts_with("RoofSurface"));
  EXPECT_EQ(noted(*scene, "closure"), 1U);
}

TEST_F(CityJson, MissingTextureIsNotedAndItsMaterialColourUsed) {
  const std::string appearance =
      R"("appearance":{"materials":[{"name":"red","diffuseColor":[1,0,0]}],"textures":[{"type":"JPG","image":"none.jpg"}],"vertices-texture":[]},)";
  const std::string objects =
      R"("a":{"type":"Building","geometry":[{"type":"MultiSurface","lod":"2","boundaries":[[[0,1,5]],[[1,2,6]]],)"
      R"("material":{"v":{"value":0}},"texture":{"v":{"values":[[[0,0,1,2]],[[null]]]}}}]})";
  const auto scene = import_text("paint.json", document(objects, kCubeVertices, appearance));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  EXPECT_EQ(noted(*scene, "missing texture"), 1U);
  ASSERT_EQ(scene->materials.size(), 1U);
  EXPECT_EQ(scene->materials[0].base_color, glm::vec3(1, 0, 0));
}

TEST_F(CityJson, TextureCoordinatesFollowTheirRings) {
  const std::string png_bytes(
      "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x02\0\0\0\x01\x08\x02\0\0\0\x7b\x40\xe8\xdd"
      "\0\0\0\x0fIDATx\x9c\x63\x60\x60\x60\xf8\xff\xff\x3f\0\x06\x01\x02\xfe\x02\xb2\x39\xae"
      "\0\0\0\0IEND\xae\x42\x60\x82",
      72);
  write("two.png", png_bytes);
  const auto document_of = [](const std::string& values,
                              const std::string& texture = R"({"image":"two.png","wrapMode":"clamp"})",
                              const std::string& last_u = "0.5") {
    return document(
        R"("a":{"type":"Building","geometry":[{"type":"MultiSurface","lod":"2","boundaries":[[[0,1,5]],[[1,2,6]]],)"
        R"("texture":{"v":{"values":)" +
            values + "}}}]}",
        kCubeVertices,
        R"("appearance":{"textures":[)" + texture + R"(],"vertices-texture":[[0,0],[1,0.25],[)" + last_u + ",1]]},");
  };
  const auto scene = import_text("paint.json", document_of("[[[0,0,1,2]],[[null]]]"));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  ASSERT_EQ(scene->texcoords.size(), 1U);
  const auto& [triangle, uv] = scene->texcoords[0];
  const Material& material = scene->materials[scene->triangle_material[triangle]];
  ASSERT_TRUE(material.texture.has_value());
  EXPECT_EQ(material.texture->wrap_u, TextureWrap::kClamp);
  for (std::size_t k = 0; k < 3; ++k) {
    // v runs downwards from here on; the surface is the corners (0 0 0), (1 0 0), (1 0 1) of the cube.
    const glm::dvec3 p = scene->positions[scene->triangles[triangle][k]] - glm::dvec3(1000000, 2000000, 10);
    const glm::vec2 expected = p.z > 0.5 ? glm::vec2(0.5F, 0) : (p.x > 0.5 ? glm::vec2(1, 0.75F) : glm::vec2(0, 1));
    EXPECT_EQ(uv[k], expected) << k;
  }
  const auto short_ring = import_text("short.json", document_of("[[[0,0,1]],[[null]]]"));
  ASSERT_TRUE(short_ring.ok()) << short_ring.error().describe();
  EXPECT_TRUE(short_ring->texcoords.empty());
  EXPECT_EQ(noted(*short_ring, "without texture coordinates"), 1U);
  const auto wrong = import_text("wrong.json", document_of("[[[0,0,1,3]],[[null]]]"));
  ASSERT_FALSE(wrong.ok());
  EXPECT_NE(wrong.error().message.find("texture coordinate index 3 out of range"), std::string::npos);
  for (const char* u : {"1e300", "-1e39", "1e10"}) {  // as a float: infinite, or too large to separate texels
    const auto huge = import_text("huge.json", document_of("[[[0,0,1,2]],[[null]]]", R"({"image":"two.png"})", u));
    ASSERT_TRUE(huge.ok()) << huge.error().describe();
    EXPECT_TRUE(huge->texcoords.empty()) << u;
    EXPECT_EQ(noted(*huge, "not finite or beyond 2^24"), 1U) << u;
  }
}

TEST_F(CityJson, NoImageIsReadOutsideTheFolderAndAllAreNamed) {
  std::filesystem::create_directories(folder_ / "in");
  write("secret.png", "no image, but it would be opened");
  const std::string names = R"({"image":"../secret.png"},{"image":")" + (folder_ / "secret.png").string() +
                            R"("},{"image":"../secret.png\u0000.jpg"},{"image":"gone.png"},{"image":"a/gone.png"})";
  std::string rings;
  std::string values;
  for (int i = 0; i < 10; ++i) {
    rings += std::string(i > 0 ? "," : "") + "[[0,1,2]]";
    values += std::string(i > 0 ? "," : "") + "[[" + std::to_string(i % 5) + ",0,0,0]]";
  }
  const auto scene = import(
      write("in/city.json",
            document(R"("a":{"type":"Building","geometry":[{"type":"MultiSurface","lod":"2","boundaries":[)" + rings +
                         R"(],"texture":{"t":{"values":[)" + values + "]}}}]}",
                     kCubeVertices, R"("appearance":{"textures":[)" + names + R"(],"vertices-texture":[[0,0]]},)")));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  ASSERT_EQ(scene->notes.size(), 2U);
  EXPECT_EQ(noted(*scene, "missing texture images"), 2U);
  EXPECT_EQ(scene->notes[0].names, (std::vector<std::string>{"gone.png", "a/gone.png"}));
  EXPECT_EQ(noted(*scene, "outside the folder"), 3U);
  EXPECT_EQ(scene->notes[1].names[0], "../secret.png");
}

TEST_F(CityJson, GeometryTemplatesArePlacedAtTheirReferencePoint) {
  const std::string templates =
      R"("geometry-templates":{"vertices-templates":[[0,0,0],[1,0,0],[0,1,0]],"templates":[{"type":"MultiSurface","lod":"2","boundaries":[[[0,1,2]]]}]},)";
  const std::string objects =
      R"("t":{"type":"SolitaryVegetationObject","geometry":[{"type":"GeometryInstance","template":0,"boundaries":[1],)"
      R"("transformationMatrix":[2,0,0,5, 0,-2,0,0, 0,0,1,0, 0,0,0,1]}]})";
  const auto scene = import_text("template.json", document(objects, "[[0,0,0],[2,0,0]]", templates));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  ASSERT_EQ(scene->triangles.size(), 1U);
  EXPECT_EQ(scene->positions[0], glm::dvec3(1000006, 2000000, 10));
  EXPECT_DOUBLE_EQ(area(*scene), 2.0);
  EXPECT_GT(normal2(*scene, 0).z, 0);  // a mirroring matrix does not turn surfaces inside out
}

TEST_F(CityJson, SequenceIsReadLineByLine) {
  const std::string header =
      R"({"type":"CityJSON","version":"2.0","transform":{"scale":[0.5,0.5,0.5],"translate":[0,0,0]},"CityObjects":{},"vertices":[]})"
      "\n";
  const auto feature = [&](const std::string& id) {
    return R"({"type":"CityJSONFeature","id":")" + id + R"(","CityObjects":{)" + cube(id) + R"(},"vertices":)" +
           kCubeVertices + "}\n";
  };
  const auto scene = import_text("town.txt", header + feature("x") + "\r\n" + feature("y"));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  expect_whole(*scene);
  EXPECT_EQ(scene->objects.size(), 2U);
  EXPECT_EQ(scene->triangles.size(), 24U);

  std::string broken = feature("y");
  broken.replace(broken.find("[0,3,2,1]"), 9, "[0,3,2,8]");
  const auto fault = import_text("town.jsonl", header + feature("x") + broken);
  ASSERT_FALSE(fault.ok());
  EXPECT_NE(fault.error().message.find("'y'"), std::string::npos);
  EXPECT_GT(fault.error().byte_offset, static_cast<std::int64_t>(header.size() + feature("x").size()));
  EXPECT_FALSE(import_text("town.jsonl", header).ok());
}

TEST_F(CityJson, InputsWithReferenceSystemsThatNobodyKnowsDoNotMerge) {
  std::string other = document(cube("b"), kCubeVertices);
  other.replace(other.find("7415"), 4, "0000");
  const std::vector<std::filesystem::path> inputs = {write("a.json", document(cube("a"), kCubeVertices)),
                                                     write("b.json", other)};
  EXPECT_FALSE(import_inputs(inputs).ok());
  // One that names none joins the other; one without a code is kept as it is written. Both are said.
  const std::string named = R"("metadata":{"referenceSystem":"https://www.opengis.net/def/crs/EPSG/0/0000"},)";
  other.erase(other.find(named), named.size());
  write("b.json", other);
  const auto joined = import_inputs(inputs);
  ASSERT_TRUE(joined.ok()) << joined.error().describe();
  ASSERT_EQ(joined->notes.size(), 1U);
  EXPECT_EQ(noted(*joined, "inputs without a reference system"), 1U);
  EXPECT_EQ(joined->notes[0].names, std::vector{inputs[1].string()});
  EXPECT_TRUE(import(inputs[1])->notes.empty());
  std::string fruit = document(cube("a"), kCubeVertices);
  fruit.replace(fruit.find("https://www.opengis.net/def/crs/EPSG/0/7415"), 43, "EPSG:banana");
  const auto odd = import_text("fruit.json", fruit);
  ASSERT_TRUE(odd.ok()) << odd.error().describe();
  EXPECT_EQ(noted(*odd, "without an EPSG code"), 1U);
  const std::vector<std::filesystem::path> same = {inputs[0], inputs[0]};
  const auto scene = import_inputs(same);
  ASSERT_TRUE(scene.ok());
  EXPECT_EQ(scene->objects.size(), 2U);
}

struct RealFile {
  const char* name;
  std::size_t triangles;
  std::size_t objects;
  double area_m2;  // Newell areas of outer rings less holes, summed by a separate program
};

class RealCity : public ::testing::TestWithParam<RealFile> {};

TEST_P(RealCity, HasItsTrianglesAndObjects) {
  const std::filesystem::path path = data_folder() / GetParam().name;
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no " << GetParam().name << "; set ZONECAST_DATA";
  const auto scene = import_inputs(std::span<const std::filesystem::path>(&path, 1));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  expect_whole(*scene);
  EXPECT_EQ(scene->triangles.size(), GetParam().triangles);
  EXPECT_EQ(scene->objects.size(), GetParam().objects);
  EXPECT_NEAR(area(*scene), GetParam().area_m2, 2e-5 * GetParam().area_m2);
}

INSTANTIATE_TEST_SUITE_P(Files, RealCity,
                         ::testing::Values(RealFile{"bayreuth.city.jsonl", 91'686, 7'652, 89517999.852},
                                           RealFile{"ingolstadt/ingolstadt.city.json", 155'518, 55, 230355.955},
                                           RealFile{"delft.city.json", 36'269, 570, 77526.088},
                                           RealFile{"rotterdam/rotterdam_subset.json", 622, 16, 10636.278}),
                         [](const auto& file) {
                           return std::filesystem::path(file.param.name).stem().stem().string();
                         });

}  // namespace
}  // namespace zc::test
