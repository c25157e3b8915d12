// SPDX-License-Identifier: GPL-3.0-or-later
// OBJ and MTL: what is read of them, and what damaged and hostile files come to.
#include <cmath>
#include <random>

#include "tests/unit/baker/import/import_support.h"
#include "tests/unit/baker/import/pictures.h"

namespace zc::test {
namespace {

class Obj : public ImportTest {
 protected:
  void write_picture(const std::string& name, std::uint32_t channels) const {
    const Bytes bytes = png(64, 48, channels);
    write(name, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  }
  Result<Scene> with_library(const std::string& library, const std::string& text) const {
    write("city.mtl", library);
    return import_text("city.obj", "mtllib city.mtl\n" + text);
  }
  static std::string error_of(const Result<Scene>& scene) { return scene.ok() ? "read" : scene.error().describe(); }
};

constexpr const char* kSquare =
    "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl wall\nf 1/1 2/2 3/3 4/4\n";

TEST_F(Obj, ObjectsHaveTheirNamesAndPolygonsTheirArea) {
  const auto scene = import_text("city.obj",
                                 "# a comment\n#\no house 1\nv 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 2 1 0\n"
                                 "f 1 2 3 4\no arrow\nf -5//9 \\\n -4 -3 -1\n");
  ASSERT_TRUE(scene.ok()) << error_of(scene);
  expect_whole(*scene);
  ASSERT_EQ(scene->objects.size(), 2U);
  EXPECT_EQ(scene->objects[0].id, "house 1");
  EXPECT_EQ(scene->objects[1].id, "arrow");
  EXPECT_DOUBLE_EQ(area(*scene), 16 + 6);  // the arrow is not convex
  for (std::size_t t = 0; t < scene->triangles.size(); ++t) EXPECT_GT(normal2(*scene, t).z, 0);
}

TEST_F(Obj, GroupsAreObjectsWhereObjectsAreNot) {
  const std::string triangle = "f 1 2 3\n";
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  const auto groups = import_text("a.obj", vertices + "o all\ng roof\n" + triangle + "g Street 5\n" + triangle);
  ASSERT_TRUE(groups.ok());
  ASSERT_EQ(groups->objects.size(), 2U);
  EXPECT_EQ(groups->objects[0].id, "roof");
  EXPECT_EQ(groups->objects[1].kind, ObjectKind::kGround);
  const auto objects =
      import_text("a.obj", vertices + "o one\ng roof\n" + triangle + "g wall\n" + triangle + "o two\n" + triangle);
  ASSERT_TRUE(objects.ok());
  ASSERT_EQ(objects->objects.size(), 2U);
  EXPECT_EQ(objects->objects[0].id, "one");
  EXPECT_EQ(objects->objects[0].triangle_count, 2U);
  const auto plain = import_text("plain.obj", vertices + triangle);
  ASSERT_TRUE(plain.ok());
  EXPECT_EQ(plain->objects[0].id, "plain");
}

TEST_F(Obj, CoordinatesKeepTheirDigits) {
  const auto scene = import_text("utm.obj",
                                 "v 412345.678 5712345.679 1e2\r\nv 412346.678 5712345.679 +1e2\r\n"
                                 "v 412345.678 5712346.679 1.0E+2\r\nf 1 2 3\r\n");
  ASSERT_TRUE(scene.ok()) << error_of(scene);
  EXPECT_EQ(scene->positions[0], glm::dvec3(412345.678, 5712345.679, 100));
}

TEST_F(Obj, FacesMayComeBeforeTheirVertices) {
  const auto scene = import_text("a.obj", "f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n");
  ASSERT_TRUE(scene.ok()) << error_of(scene);
  EXPECT_EQ(scene->triangles.size(), 1U);
}

TEST_F(Obj, MaterialsAreThoseOfTheLibrary) {
  const auto scene = with_library(
      "newmtl glass\nKd 1 0 0.5\nKs 0.5 0.5 0.5\nNs 1000\nnewmtl mirror\r\nKd 0 0 0\r\nPr 0\r\nPm 1\r\n"
      "newmtl matte\nKs 0 0 0\nNs 1000\n",
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl glass\nf 1 2 3\nusemtl mirror\nf 1 2 3\nusemtl matte\nf 1 2 3\n"
      "usemtl none\nf 1 2 3\n");
  ASSERT_TRUE(scene.ok()) << error_of(scene);
  ASSERT_EQ(scene->materials.size(), 4U);
  const auto of = [&](std::size_t t) { return scene->materials[scene->triangle_material[t]]; };
  EXPECT_EQ(of(0).name, "glass");
  EXPECT_FLOAT_EQ(of(0).base_color.x, 1);
  EXPECT_EQ(of(0).base_color.y, 0);
  EXPECT_FLOAT_EQ(of(0).base_color.z, srgb_to_linear(0.5F));
  EXPECT_NEAR(of(0).roughness, std::pow(2.0 / 1002, 0.25), 1e-6);
  EXPECT_EQ(of(1).roughness, 0);
  EXPECT_EQ(of(1).metallic, 1);
  EXPECT_FLOAT_EQ(of(2).roughness, 0.9F);
  EXPECT_EQ(of(3).name, "none");
  EXPECT_EQ(noted(*scene, "no library defines"), 1U);
}

TEST_F(Obj, TexturesStandAsTheirCoordinatesSay) {
  std::filesystem::create_directories(folder_ / "tex");
  write_picture("tex/a wall.png", 3);
  const auto scene = with_library("newmtl wall\nmap_Kd -clamp on -s 1 1 1 -o 0 0 0 tex\\a wall.png\n", kSquare);
  ASSERT_TRUE(scene.ok()) << error_of(scene);
  ASSERT_EQ(scene->images.size(), 1U);
  ASSERT_EQ(scene->texcoords.size(), 2U);
  const Material& material = scene->materials[scene->triangle_material[0]];
  ASSERT_TRUE(material.texture);
  EXPECT_EQ(material.texture->wrap_u, TextureWrap::kClamp);
  // The corner at the origin has the lower left end of the image: v is 1 there.
  for (std::size_t t = 0; t < 2; ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::dvec3& p = scene->positions[scene->triangles[t][k]];
      const glm::vec2 uv = scene->texcoords[t].uv[k];
      EXPECT_FLOAT_EQ(uv.x, static_cast<float>(p.x / 4));
      EXPECT_FLOAT_EQ(uv.y, static_cast<float>(1 - p.y / 4));
    }
  const auto scaled = with_library("newmtl wall\nmap_Kd -s 2 3 1 -o 0.5 0 0 tex/a wall.png\n", kSquare);
  ASSERT_TRUE(scaled.ok());
  for (std::size_t k = 0; k < 3; ++k) {
    const glm::dvec3& p = scaled->positions[scaled->triangles[0][k]];
    EXPECT_FLOAT_EQ(scaled->texcoords[0].uv[k].x, static_cast<float>(0.5 + p.x / 2));
    EXPECT_FLOAT_EQ(scaled->texcoords[0].uv[k].y, static_cast<float>(1 - 0.75 * p.y));
  }
}

TEST_F(Obj, ATextureStaysWhereAnOutlineCrossesItself) {
  write_picture("wall.png", 3);
  const auto scene = with_library("newmtl wall\nmap_Kd wall.png\n",
                                  "v 0 0 0\nv 4 4 0\nv 4 0 0\nv 0 2 0\nvt 0 0\nvt 1 1\nvt 1 0\nvt 0 0.5\n"
                                  "usemtl wall\nf 1/1 2/2 3/3 4/4\n");
  ASSERT_TRUE(scene.ok()) << error_of(scene);
  EXPECT_EQ(scene->positions.size(), 5U);  // with the crossing
  ASSERT_EQ(scene->texcoords.size(), 2U);
  for (std::size_t t = 0; t < 2; ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::dvec3& p = scene->positions[scene->triangles[t][k]];
      EXPECT_NEAR(scene->texcoords[t].uv[k].x, p.x / 4, 1e-6);
      EXPECT_NEAR(scene->texcoords[t].uv[k].y, 1 - p.y / 4, 1e-6);
    }
}

TEST_F(Obj, WhatIsTransparentIsCutOff) {
  write_picture("wall.png", 4);  // the lower half is transparent
  const auto own = with_library("newmtl wall\nmap_Kd wall.png\nmap_d wall.png\n", kSquare);
  ASSERT_TRUE(own.ok()) << error_of(own);
  EXPECT_NEAR(area(*own), 8, 0.3);
  for (const glm::dvec3& p : own->positions) EXPECT_GE(p.y, 1.9);
  EXPECT_EQ(own->texcoords.size(), own->triangles.size());
  // Without map_d alpha means nothing; a grey image is its own alpha.
  const auto opaque = with_library("newmtl wall\nmap_Kd wall.png\n", kSquare);
  ASSERT_TRUE(opaque.ok());
  EXPECT_DOUBLE_EQ(area(*opaque), 16);
  Bytes grey = png(64, 48, 1);
  write("grey.png", {reinterpret_cast<const char*>(grey.data()), grey.size()});
  const auto apart = with_library("newmtl wall\nmap_d grey.png\n", kSquare);  // its left is light
  ASSERT_TRUE(apart.ok());
  EXPECT_NEAR(area(*apart), 8, 0.3);
  for (const glm::dvec3& p : apart->positions) EXPECT_TRUE(p.x < 2.1 || p.x > 3.9) << p.x;  // where it repeats
  for (const char* pane : {"d 0.2", "Tr 0.8"}) {
    const auto kept = with_library(std::string("newmtl wall\n") + pane + "\n", kSquare);
    ASSERT_TRUE(kept.ok());
    EXPECT_DOUBLE_EQ(area(*kept), 16);
    EXPECT_EQ(noted(*kept, "panes"), 2U) << pane;
  }
}

TEST_F(Obj, WhatIsCutOffIsBoundedByTheFile) {
  std::mt19937 random(3);
  std::vector<std::uint8_t> noise(std::size_t{64} * 64 * 4);
  for (std::uint8_t& value : noise) value = static_cast<std::uint8_t>(random());
  const Bytes image = png_of(noise, 64, 64, 4);
  write("noise.png", {reinterpret_cast<const char*>(image.data()), image.size()});
  std::string text = "v 0 0 0\nv 4 0 0\nv 0 4 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl wall\n";
  constexpr int kObjects = 1000;
  for (int i = 0; i < kObjects; ++i) text += "o " + std::to_string(i) + "\nf 1/1 2/2 3/3\n";
  const auto scene = with_library("newmtl wall\nmap_d noise.png\n", text);
  ASSERT_TRUE(scene.ok()) << error_of(scene);
  EXPECT_EQ(scene->objects.size(), std::size_t{kObjects});
  EXPECT_LT(scene->triangles.size(), (1U << 20U) + 4 * text.size() + (1U << 14U));
  EXPECT_GT(noted(*scene, "kept whole"), 0U);
  EXPECT_GT(noted(*scene, "cut off"), 100U);
}

TEST_F(Obj, VertexColoursAreThoseOfTheTriangle) {
  for (const char* red : {"0.5 0 0", "127.5 0 0", "1.0 0.5 0 0"}) {
    const std::string r = red;
    const auto scene = import_text("a.obj", "v 0 0 0 " + r + "\nv 1 0 0 " + r + "\nv 0 1 0 " + r + "\nv 5 5 0 " + r +
                                                "\nv 6 6 0 " + "\nf 1 2 3\n");
    ASSERT_TRUE(scene.ok()) << error_of(scene);
    const glm::vec3 color = scene->materials[scene->triangle_material[0]].base_color;
    EXPECT_FLOAT_EQ(color.x, srgb_to_linear(0.5F)) << red;
    EXPECT_EQ(color.y, 0);
  }
  const auto painted = with_library("newmtl wall\nKd 0.5 0.5 0.5\n",
                                    "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\nusemtl wall\nf 1 2 3\n");
  ASSERT_TRUE(painted.ok()) << error_of(painted);
  EXPECT_FLOAT_EQ(painted->materials[painted->triangle_material[0]].base_color.x, srgb_to_linear(0.5F));
}

TEST_F(Obj, LibrariesAndImagesOutsideTheFolderAreNotRead) {
  write("secret.mtl", "newmtl wall\nKd 1 0 0\n");
  std::filesystem::create_directories(folder_ / "in");
  for (const char* name : {"../secret.mtl", "..\\secret.mtl", "/etc/passwd"}) {
    const auto scene = import_text("in/a.obj", std::string("mtllib ") + name + "\n" + kSquare);
    ASSERT_TRUE(scene.ok()) << error_of(scene);
    EXPECT_EQ(noted(*scene, "outside the folder"), 1U) << name;
    EXPECT_EQ(scene->materials[scene->triangle_material[0]].base_color, glm::vec3(0.8F));
  }
  write_picture("secret.png", 3);
  write("in/a.mtl", "newmtl wall\nmap_Kd ../secret.png\n");
  const auto image = import_text("in/a.obj", std::string("mtllib a.mtl none.mtl\n") + kSquare);
  ASSERT_TRUE(image.ok());
  EXPECT_TRUE(image->images.empty());
  EXPECT_EQ(noted(*image, "texture images that lie outside"), 1U);
  EXPECT_EQ(noted(*image, "not there, grey"), 1U);
}

TEST_F(Obj, FaultsAreNamedWithTheirPlace) {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  const auto fault = [&](const std::string& text) { return error_of(import_text("a.obj", text)); };
  EXPECT_NE(fault("v 0,5 0 0\n" + vertices + "f 1 2 3\n").find("byte 2: '0,5' is no number"), std::string::npos);
  EXPECT_NE(fault("v 0 0\n").find("has 2 numbers, expected 3"), std::string::npos);
  for (const char* index : {"4", "0", "-4", "99999999999999999999", "4294967297", "x", "1.5", "/1", "1/1", "1/x"})
    EXPECT_NE(fault(vertices + "f " + index + " 2 3\n").find("a face names the "), std::string::npos) << index;
  EXPECT_NE(fault(vertices).find("has no triangles"), std::string::npos);
  const auto infinite = import_text("a.obj", vertices + "v nan 0 0\nv 1e999 0 0\nf 1 2 3\nf 1 2 4\nf 1 2 5\n");
  ASSERT_TRUE(infinite.ok());
  EXPECT_EQ(infinite->triangles.size(), 1U);
  EXPECT_EQ(noted(*infinite, "not finite"), 2U);
}

TEST_F(Obj, LongLinesAndManyNamesTakeTimeAndMemoryOfTheirSize) {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  std::string polygon = vertices + "f";
  for (int i = 0; i < 300'000; ++i) polygon += " 1 2 3";
  EXPECT_TRUE(import_text("a.obj", polygon + "\nf 1 2 3\n").ok());
  EXPECT_FALSE(import_text("a.obj", vertices + "f " + std::string(8'000'000, '1') + " 2 3\n").ok());
  EXPECT_TRUE(import_text("a.obj", vertices + "#" + std::string(8'000'000, '\\') + "\nf 1 2 3\n").ok());
  std::string library;
  std::string uses = vertices;
  for (int i = 0; i < 20'000; ++i) {
    library += "newmtl " + std::to_string(i) + "\n";
    uses += "usemtl " + std::to_string(i) + "\ng " + std::to_string(i) + "\n";
  }
  EXPECT_TRUE(with_library(library, uses + "f 1 2 3\n").ok());
}

TEST_F(Obj, DamageEndsInOneLineAndNeverInACrash) {
  write_picture("wall.png", 4);
  const std::string library =
      "newmtl wall\nKd 1 0 0\nd 0.9\nNs 100\nKs 1 1 1\nmap_Kd -s 2 2 2 wall.png\nmap_d wall.png\n";
  const std::string text = std::string("mtllib city.mtl\no a\ng b\n") + kSquare + "f -1 -2 -3 -4 1 \\\n 2\nl 1 2\n";
  const std::string spare = " \n\\\r#/-+.0e9fvtg\xFF";
  std::mt19937 random(7);
  for (int i = 0; i < 1000; ++i) {
    std::string damaged = text;
    std::string damaged_library = library;
    for (int change = 0; change < 3; ++change) {
      std::string& of = random() % 3 == 0 ? damaged_library : damaged;
      const std::size_t at = random() % of.size();
      if (random() % 4 == 0)
        of.erase(at, random() % 8);
      else
        of[at] = spare[random() % spare.size()];
      if (of.empty()) of = " ";
    }
    if (i < static_cast<int>(text.size())) damaged.resize(static_cast<std::size_t>(i));
    write("city.mtl", damaged_library);
    const auto scene = import_text("city.obj", damaged);
    expect_whole_or_refused(scene);
  }
}

}  // namespace
}  // namespace zc::test
