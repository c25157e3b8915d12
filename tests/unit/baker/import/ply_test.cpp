// SPDX-License-Identifier: GPL-3.0-or-later
// PLY: what is read of it in its three forms, and what damaged and hostile files come to.
#include <bit>
#include <cmath>
#include <random>

#include "tests/unit/baker/import/deflated.h"
#include "tests/unit/baker/import/import_support.h"
#include "tests/unit/baker/import/pictures.h"

namespace zc::test {
namespace {

class Ply : public ImportTest {
 protected:
  static std::string error_of(const Result<Scene>& scene) { return scene.ok() ? "read" : scene.error().describe(); }
  // A square and an arrow of one more vertex, at coordinates of a city; red, and the last vertex blue.
  static std::string model(const std::string& form) {
    std::string file = "ply\nformat " + form +
                       " 1.0\ncomment made by hand\nelement vertex 5\nproperty double x\n"
                       "property double y\nproperty float z\nproperty uchar red\nproperty uchar green\n"
                       "property uchar blue\nelement face 2\nproperty list uchar int vertex_indices\nproperty short "
                       "number\nelement edge 1\nproperty list ushort int8 ends\nend_header\n";
    const bool is_text = form == "ascii";
    const auto put = [&]<class T>(T value) {
      if (is_text) {
        file += std::to_string(+value) + ' ';
        return;
      }
      std::string bytes;
      append(bytes, value);
      file += form == "binary_big_endian" ? std::string(bytes.rbegin(), bytes.rend()) : bytes;
    };
    const std::array<std::array<double, 2>, 5> corners = {{{0, 0}, {4, 0}, {4, 4}, {0, 4}, {2, 1}}};
    for (std::size_t i = 0; i < 5; ++i) {
      put(412345.678125 + corners[i][0]);
      put(5712345.678125 + corners[i][1]);
      put(-1.5F);
      put(std::uint8_t{255});
      put(std::uint8_t{0});
      put(std::uint8_t(i == 4 ? 255 : 0));
    }
    for (const std::vector<std::int32_t>& face : {std::vector<std::int32_t>{0, 1, 2, 3}, {0, 1, 4, 3}}) {
      put(static_cast<std::uint8_t>(face.size()));
      for (const std::int32_t corner : face) put(corner);
      put(std::int16_t{-300});
    }
    put(std::uint16_t{2});
    put(std::int8_t{0});
    put(std::int8_t{1});
    return file;
  }
  static std::string header(const std::string& vertices, const std::string& faces, const std::string& more = "") {
    return "ply\nformat ascii 1.0\n" + more + "element vertex " + vertices +
           "\nproperty float x\nproperty float y\nproperty float z\nelement face " + faces +
           "\nproperty list uchar int vertex_index\nend_header\n";
  }
};

TEST_F(Ply, EveryFormIsTheSameModel) {
  for (const char* form : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    const auto scene = import_text("square.ply", model(form));
    ASSERT_TRUE(scene.ok()) << form << error_of(scene);
    expect_whole(*scene);
    ASSERT_EQ(scene->objects.size(), 1U);
    EXPECT_EQ(scene->objects[0].id, "square");
    ASSERT_EQ(scene->positions.size(), 5U) << form;
    EXPECT_EQ(scene->positions[0], glm::dvec3(412345.678125, 5712345.678125, -1.5)) << form;
    EXPECT_DOUBLE_EQ(area(*scene), 16 + 6) << form;
    for (std::size_t t = 0; t < scene->triangles.size(); ++t) EXPECT_GT(normal2(*scene, t).z, 0);
    const glm::vec3 red = scene->materials[scene->triangle_material[0]].base_color;
    EXPECT_EQ(red, glm::vec3(1, 0, 0));
    const glm::vec3 mixed = scene->materials[scene->triangle_material.back()].base_color;
    EXPECT_NEAR(mixed.z, 1.0 / 3, 0.03);
  }
}

TEST_F(Ply, LinesMayEndInOtherWays) {
  std::string text = model("ascii");
  for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2) text.insert(at, "\r");
  EXPECT_TRUE(import_text("a.ply", text).ok());
  std::string binary = model("binary_big_endian");
  const std::size_t data = binary.find("end_header\n") + 11;
  for (const char* end : {"\r", "\r\n"}) {
    std::string other;
    for (const char c : binary.substr(0, data)) other += c == '\n' ? end : std::string(1, c);
    const auto scene = import_text("a.ply", other + binary.substr(data));
    ASSERT_TRUE(scene.ok()) << error_of(scene);
    EXPECT_DOUBLE_EQ(area(*scene), 22);
  }
}

TEST_F(Ply, FacesHaveColoursOfTheirOwn) {
  const auto scene = import_text("a.ply",
                                 "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                                 "property float z\nelement face 2\nproperty list uchar int vertex_index\n"
                                 "property float red\nproperty float green\nproperty float blue\nend_header\n"
                                 "0 0 0 1 0 0 0 1 0\n3 0 1 2 0 1 0\n3 0 2 1 0.5 7 nan\n");
  ASSERT_TRUE(scene.ok()) << error_of(scene);
  EXPECT_EQ(scene->materials[scene->triangle_material[0]].base_color, glm::vec3(0, 1, 0));
  const glm::vec3 other = scene->materials[scene->triangle_material[1]].base_color;
  EXPECT_FLOAT_EQ(other.x, srgb_to_linear(0.5F));
  EXPECT_EQ(other.y, 1);
  EXPECT_EQ(other.z, 0);
}

TEST_F(Ply, ManyColoursBecomeSteps) {
  constexpr int kFaces = 70'000;
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face " +
      std::to_string(kFaces) +
      "\nproperty list uchar int vertex_index\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n0 0 0 1 0 0 0 1 0\n";
  for (int i = 0; i < kFaces; ++i)
    text += "3 0 1 2 " + std::to_string(i % 256) + " " + std::to_string(i / 256 % 256) + " 128\n";
  const auto scene = import_text("a.ply", text);
  ASSERT_TRUE(scene.ok()) << error_of(scene);
  EXPECT_EQ(scene->triangles.size(), std::size_t{kFaces});
  EXPECT_LE(scene->materials.size(), 32U * 32U * 2U);
  EXPECT_EQ(noted(*scene, "materials beyond"), 0U);
}

TEST_F(Ply, TexturesAreThoseThatTheCommentsName) {
  const Bytes picture = png(64, 48, 3);
  write("wall.png", {reinterpret_cast<const char*>(picture.data()), picture.size()});
  const std::string head =
      "ply\nformat ascii 1.0\ncomment TextureFile wall.png\nelement vertex 3\nproperty float x\n"
      "property float y\nproperty float z\n";
  const auto corners = import_text("a.ply", head +
                                                "element face 2\nproperty list uchar int vertex_indices\n"
                                                "property list uchar float texcoord\nproperty int texnumber\n"
                                                "end_header\n0 0 0 1 0 0 0 1 0\n3 0 1 2 6 0 0 1 0 0 1 0\n"
                                                "3 0 1 2 6 0 0 1 0 0 1 9\n");
  ASSERT_TRUE(corners.ok()) << error_of(corners);
  ASSERT_EQ(corners->texcoords.size(), 1U);
  EXPECT_EQ(corners->texcoords[0].uv[2], glm::vec2(0, 0));
  EXPECT_EQ(corners->texcoords[0].uv[1], glm::vec2(1, 1));
  EXPECT_EQ(noted(*corners, "whose texture is not named"), 1U);
  const auto vertices = import_text("a.ply", head +
                                                 "property float s\nproperty float t\nelement face 1\n"
                                                 "property list uchar int vertex_indices\nend_header\n"
                                                 "0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n");
  ASSERT_TRUE(vertices.ok()) << error_of(vertices);
  ASSERT_EQ(vertices->texcoords.size(), 1U);
  EXPECT_EQ(vertices->texcoords[0].uv[2], glm::vec2(0, 0));
}

TEST_F(Ply, FaultsAreNamed) {
  const auto fault = [&](const std::string& text) { return error_of(import_text("a.ply", text)); };
  const std::string points = "0 0 0\n1 0 0\n0 1 0\n";
  EXPECT_EQ(fault(header("3", "1") + points + "3 0 1 2\n"), "read");
  EXPECT_NE(fault(header("4000000000", "1") + points).find("declares 4000000000"), std::string::npos);
  EXPECT_NE(fault(header("99999999999999999999", "1")).find("without a name and a count"), std::string::npos);
  EXPECT_NE(fault(header("3", "-1")).find("without a name and a count"), std::string::npos);
  EXPECT_NE(fault(header("3", "2") + points + "3 0 1 2\n255 1\n").find("a list of more values"), std::string::npos);
  EXPECT_NE(fault(header("3", "1") + points + "3 0 1 3\n").find("names vertex 3"), std::string::npos);
  EXPECT_NE(fault(header("3", "1") + points + "3 0 1 -1\n").find("cannot be"), std::string::npos);
  EXPECT_NE(fault(header("3", "1") + points + "3 0 1 0.5\n").find("cannot be"), std::string::npos);
  EXPECT_NE(fault(header("3", "1") + points + "3 0 1 nan\n").find("cannot be"), std::string::npos);
  EXPECT_NE(fault(header("3", "1") + points + "3 0 1 x\n").find("'x' is no number"), std::string::npos);
  EXPECT_NE(fault(header("3", "1") + "0.0000000 0.0000000 0\n1 0 0\n").find("ends early"), std::string::npos);
  EXPECT_NE(fault(header("3", "0") + points).find("point cloud"), std::string::npos);
  EXPECT_NE(fault("ply\nformat binary 1.0\n").find("expected ascii, binary_little"), std::string::npos);
  EXPECT_NE(fault("ply\nformat ascii 1.0\n").find("no end_header"), std::string::npos);
  EXPECT_NE(fault("ply\nend_header\n").find("without a format"), std::string::npos);
  EXPECT_NE(fault("ply\nformat ascii 1.0\nproperty float x\n").find("none of an element"), std::string::npos);
  EXPECT_NE(fault("ply\nformat ascii 1.0\nelement tristrips 0\nend_header\n").find("strips"), std::string::npos);
  // Nothing per item: no time per item either.
  EXPECT_NE(fault("ply\nformat ascii 1.0\nelement none 9000000000000000000\nend_header\n").find("no triangles"),
            std::string::npos);
}

TEST_F(Ply, PackedAndInFoldersToo) {
  const std::string square = model("binary_little_endian");
  const auto packed = import_text("square.ply.gz", gzipped(square));
  ASSERT_TRUE(packed.ok()) << error_of(packed);
  EXPECT_DOUBLE_EQ(area(*packed), 22);
  std::filesystem::create_directories(folder_ / "city");
  write("city/a.PLY", square);
  write("city/b.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const auto folder = import(folder_ / "city");
  ASSERT_TRUE(folder.ok()) << error_of(folder);
  EXPECT_EQ(folder->objects.size(), 2U);
}

TEST_F(Ply, DamageEndsInOneLineAndNeverInACrash) {
  std::mt19937 random(11);
  for (const char* form : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    const std::string whole = model(form);
    for (std::size_t i = 0; i < 600; ++i) {
      std::string damaged = whole;
      for (int change = 0; change < 2; ++change) {
        char& changed = damaged[random() % damaged.size()];
        changed = static_cast<char>(changed ^ static_cast<char>(1U << random() % 8));
      }
      if (i < whole.size()) damaged.resize(i);
      const auto scene = import_text("a.ply", damaged);
      expect_whole_or_refused(scene);
    }
  }
}

}  // namespace
}  // namespace zc::test
