// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/encode/zone_glb.h"

#include <draco/compression/decode.h>
#include <draco/mesh/mesh.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>

#include "baker/repair/snap.h"
#include "streamer/world_format/bvh_page.h"
#include "tests/unit/baker/stages.h"
#include "tests/unit/baker/test_city.h"

namespace zc {
namespace {

using Corners = std::array<LatticePoint, 3>;
using Tagged = std::pair<Corners, std::uint16_t>;

Tagged tagged(Corners corners, std::uint16_t material) {
  std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
  return {corners, material};
}

NodeRecord record_of(const EncodedZone& zone, std::uint32_t shift) {
  NodeRecord node;
  node.step_shift = shift;
  node.origin = zone.origin;
  node.bounds_min = zone.bounds_min;
  node.bounds_max = zone.bounds_max;
  node.triangle_count = zone.triangle_count;
  node.vertex_count = zone.vertex_count;
  node.primitive_count = zone.primitive_count;
  node.glb_bytes = zone.glb.size();
  node.scratch_bytes = decode_scratch_bound(node, zone.glb.size());
  return node;
}

void expect_round_trip(LatticeMesh mesh, std::uint32_t shift, std::span<const Material> materials) {
  round_to_step(mesh, shift);
  auto zone = encode_zone_glb(mesh, shift, materials, 1.0 / 256);
  ASSERT_TRUE(zone.ok());
  const NodeRecord node = record_of(*zone, shift);
  auto decoded = decode_zone_glb(zone->glb, node, "test.glb");
  ASSERT_TRUE(decoded.ok()) << decoded.error().describe();
  ASSERT_EQ(zone->materials.size(), decoded->triangles.size());
  std::vector<Tagged> before, after;
  for (const auto& face : mesh.faces)
    before.push_back(
        tagged({mesh.vertices[face.v[0]], mesh.vertices[face.v[1]], mesh.vertices[face.v[2]]}, face.material));
  for (std::size_t i = 0; i < decoded->triangles.size(); ++i) {
    Corners corners;
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t axis = 0; axis < 3; ++axis)
        corners[k][axis] = node.origin[axis] + (decoded->vertices[decoded->triangles[i][k]][axis] << shift);
    after.push_back(tagged(corners, zone->materials[i]));
  }
  std::sort(before.begin(), before.end());
  std::sort(after.begin(), after.end());
  EXPECT_EQ(before, after);
}

TEST(Encode, EveryTriangleAndMaterialComesBackExactly) {
  auto scene = test::snap(test::small_city());
  ASSERT_TRUE(scene.ok());
  expect_round_trip(scene->mesh, 1, scene->materials);
  expect_round_trip(scene->mesh, 4, scene->materials);
}

TEST(Encode, ASingleTriangleAndNonManifoldSoupComeBack) {
  const std::vector<Material> materials(2);
  LatticeMesh one;
  one.vertices = {{0, 0, 0}, {10, 0, 0}, {0, 10, 3}};
  one.faces = {{{0, 1, 2}, 1, false}};
  expect_round_trip(one, 0, materials);
  LatticeMesh fan = one;
  for (int i = 0; i < 5; ++i) {
    fan.vertices.push_back({5 + i, 7 * i, 90});
    fan.faces.push_back({{0, 1, static_cast<std::uint32_t>(3 + i)}, 0, false});
    fan.faces.push_back({{1, 0, static_cast<std::uint32_t>(3 + i)}, 1, false});
  }
  expect_round_trip(fan, 0, materials);
}

TEST(Encode, MoreVerticesThanSixteenBitsCanNumber) {
  LatticeMesh mesh;
  for (std::uint32_t i = 0; i < 70000; ++i) {
    const auto x = static_cast<std::int32_t>(i % 300) * 8;
    const auto y = static_cast<std::int32_t>(i / 300) * 8;
    mesh.vertices.insert(mesh.vertices.end(), {{x, y, 0}, {x + 5, y, 1}, {x, y + 5, 2}});
    mesh.faces.push_back({{3 * i, 3 * i + 1, 3 * i + 2}, 0, false});
  }
  expect_round_trip(mesh, 0, std::vector<Material>(1));
}

TEST(Encode, TheGlbDeclaresWhatItUses) {
  auto scene = test::snap(test::small_city());
  ASSERT_TRUE(scene.ok());
  round_to_step(scene->mesh, 2);
  auto zone = encode_zone_glb(scene->mesh, 2, scene->materials, 1.0 / 256);
  ASSERT_TRUE(zone.ok());
  EXPECT_EQ(zone->glb.size() % 4, 0U);
  std::uint32_t length = 0;
  std::memcpy(&length, zone->glb.data() + 12, 4);
  const auto* text = reinterpret_cast<const char*>(zone->glb.data()) + 20;
  const auto json = nlohmann::json::parse(text, text + length);
  EXPECT_EQ(json["extensionsRequired"].size(), 2U);
  ASSERT_EQ(json["meshes"][0]["primitives"].size(), 1U);
  const auto& attributes = json["meshes"][0]["primitives"][0]["attributes"];
  EXPECT_EQ(json["accessors"][attributes["COLOR_0"].get<std::size_t>()]["count"],
            json["accessors"][attributes["POSITION"].get<std::size_t>()]["count"]);
  EXPECT_EQ(json["nodes"][0]["matrix"].size(), 16U);
  EXPECT_DOUBLE_EQ(json["nodes"][0]["matrix"][0], 4.0 / 256);
  const auto& primitive = json["meshes"][0]["primitives"][0];
  const std::size_t triangles =
      json["accessors"][primitive["indices"].get<std::size_t>()]["count"].get<std::size_t>() / 3;
  EXPECT_EQ(triangles, scene->mesh.faces.size());
}

// As viewers see it: 255ths of the brightest, times that.
TEST(Encode, ATrianglesColourIsThatOfItsMaterial) {
  std::vector<Material> materials(3);
  materials[0].base_color = {0.5F, 0.1F, 0};
  materials[1].base_color = {0.25F, 0.4F, 0};
  materials[2].base_color = {0.5F, 0.1F, 0};
  LatticeMesh mesh;
  mesh.vertices = {{0, 0, 0}, {100, 0, 0}, {0, 100, 0}, {100, 100, 0}, {200, 100, 7}};
  mesh.faces = {{{0, 1, 2}, 0, false}, {{1, 3, 2}, 1, false}, {{1, 4, 3}, 2, false}};
  const auto zone = encode_zone_glb(mesh, 0, materials, 1.0);
  ASSERT_TRUE(zone.ok());
  std::uint32_t length = 0;
  std::memcpy(&length, zone->glb.data() + 12, 4);
  const auto* text = reinterpret_cast<const char*>(zone->glb.data()) + 20;
  const auto json = nlohmann::json::parse(text, text + length);
  const auto factor = json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"];
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(zone->glb.data()) + 28 + length, zone->glb.size() - 28 - length);
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  ASSERT_TRUE(decoded.ok());
  const draco::Mesh& back = *decoded.value();
  const auto* color = back.GetNamedAttribute(draco::GeometryAttribute::COLOR);
  ASSERT_NE(color, nullptr);
  ASSERT_EQ(back.num_faces(), 3U);
  for (std::uint32_t f = 0; f < 3; ++f)
    for (std::size_t k = 0; k < 3; ++k) {
      std::array<std::uint8_t, 3> rgb{};
      color->GetMappedValue(back.face(draco::FaceIndex(f))[k], rgb.data());
      const glm::vec3& expected = materials[zone->materials[f]].base_color;
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(rgb[static_cast<std::size_t>(c)] / 255.0 * factor[static_cast<std::size_t>(c)].get<double>(),
                    expected[c], 0.002);
    }
}

}  // namespace
}  // namespace zc
