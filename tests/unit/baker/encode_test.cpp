// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/encode.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>

#include "baker/snap.h"
#include "streamer/world_format/bvh_page.h"
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
  std::vector<Tagged> before, after;
  for (const auto& face : mesh.faces)
    before.push_back(
        tagged({mesh.vertices[face.v[0]], mesh.vertices[face.v[1]], mesh.vertices[face.v[2]]}, face.material));
  for (std::size_t i = 0; i < decoded->triangles.size(); ++i) {
    Corners corners;
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t axis = 0; axis < 3; ++axis)
        corners[k][axis] = node.origin[axis] + (decoded->vertices[decoded->triangles[i][k]][axis] << shift);
    after.push_back(tagged(corners, decoded->materials[i]));
  }
  std::sort(before.begin(), before.end());
  std::sort(after.begin(), after.end());
  EXPECT_EQ(before, after);
}

TEST(Encode, EveryTriangleAndMaterialComesBackExactly) {
  auto scene = snap_scene(test::small_city(), -8);
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
  auto scene = snap_scene(test::small_city(), -8);
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
  EXPECT_EQ(json["meshes"][0]["primitives"].size(), 4U);
  EXPECT_EQ(json["nodes"][0]["matrix"].size(), 16U);
  EXPECT_DOUBLE_EQ(json["nodes"][0]["matrix"][0], 4.0 / 256);
  std::size_t triangles = 0;
  for (const auto& primitive : json["meshes"][0]["primitives"]) {
    triangles += json["accessors"][primitive["indices"].get<std::size_t>()]["count"].get<std::size_t>() / 3;
    const auto& view =
        json["bufferViews"][primitive["extensions"]["KHR_draco_mesh_compression"]["bufferView"].get<std::size_t>()];
    EXPECT_EQ(view["byteOffset"].get<std::size_t>() % 4, 0U);
  }
  EXPECT_EQ(triangles, scene->mesh.faces.size());
}

}  // namespace
}  // namespace zc
