// SPDX-License-Identifier: Apache-2.0
// The file formats, held to files made once: what is written today must equal them byte for byte, and reading them must
// give the values below. A test that fails here means a new format version, with a new file beside the old one.
// ZONECAST_REWRITE_GOLDEN=1 writes the files.
#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "base/file.h"
#include "streamer/world_format/bvh_page.h"
#include "streamer/world_format/world_index.h"

namespace zc {
namespace {

constexpr std::uint32_t kMaterials = 2;

// The file's bytes, after it was compared with (or replaced by) what is written today.
std::vector<std::byte> golden(const std::string& name, const std::vector<std::byte>& now) {
  const std::filesystem::path file = std::filesystem::path("tests/golden") / name;
  const char* rewrite = std::getenv("ZONECAST_REWRITE_GOLDEN");
  if (rewrite != nullptr && std::string(rewrite) == "1") {
    EXPECT_TRUE(write_file(file, now).ok());
  }
  const auto bytes = read_file(file, 1 << 20);
  EXPECT_TRUE(bytes.ok()) << bytes.error().describe();
  if (!bytes.ok()) return {};
  EXPECT_TRUE(*bytes == now) << name << " is not what is written today";
  return *bytes;
}

// Two of a vehicle's triangles in one leaf, a third below a second node.
ZoneMesh make_mesh() {
  ZoneMesh mesh;
  mesh.vertices = {{0, 0, 0}, {256, 0, 0}, {256, 512, 1}, {0, 512, 2}, {65535, 40000, 300}, {60000, 65535, 65535}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}, {0, 2, 3}};
  mesh.materials = {0, 1, 0};
  return mesh;
}

std::uint32_t pair(std::uint32_t low, std::uint32_t high) { return low | high << 16U; }

BvhFile make_bvh() {
  const auto leaf = [](std::uint32_t first, std::uint32_t count) {
    return gpu::kRefLeaf | count << gpu::kRefCountShift | first;
  };
  BvhFile bvh;
  bvh.depth = 2;
  bvh.order = {0, 2, 1};
  bvh.nodes.push_back(
      {pair(0, 0), pair(0, 256), pair(512, 2), pair(0, 512), pair(2, 65535), pair(65535, 65535), leaf(0, 2), 1});
  bvh.nodes.push_back({pair(0, 512), pair(2, 65535), pair(65535, 65535), 0, 0, 0, leaf(2, 1), gpu::kRefNone});
  return bvh;
}

NodeRecord make_node() {
  NodeRecord node;
  node.bounds_max = {65535, 65535, 65535};
  node.error_max_m = 1.5F;
  node.error_mean_m = 0.25F;
  node.normal_deviation_deg = 30;
  node.color_error = 0.125F;
  node.triangle_count = 3;
  node.vertex_count = 6;
  node.bvh_node_count = 2;
  node.bvh_depth = 2;
  node.page_bytes = 4 * (8 + 2 * 8 + 3 * 5);
  node.scratch_bytes = 123456;
  node.primitive_count = 2;
  node.glb_bytes = 4321;
  node.bvh_bytes = 16 + 2 * 32 + 3 * 4;
  node.glb_xxh3 = 0x0123456789ABCDEFULL;
  node.bvh_xxh3 = 0xFEDCBA9876543210ULL;
  return node;
}

WorldIndex make_index() {
  WorldIndex index;
  index.header.anchor = {177'000'000, 1'382'400'000, -256};
  index.header.bounds_min = {0, 0, 0};
  index.header.bounds_max = {131070, 65535, 65535};
  index.header.source_triangles = 1'000'000'007;
  index.crs = "EPSG:25832";
  index.materials = {{{0.5F, 0.25F, 0.125F}, 0.75F, 0}, {{0.04F, 0.05F, 0.06F}, 0.0F, 1}};

  NodeRecord root = make_node();
  root.first_child = 1;
  root.child_count = 2;
  root.step_shift = 1;
  root.bounds_max = {131070, 65535, 65535};
  NodeRecord west = make_node();
  west.parent = 0;
  west.depth = 1;
  NodeRecord east = west;
  east.cell_x = 1;
  east.first_child = 3;
  east.child_count = 1;
  east.origin = {65535, 0, 0};
  east.bounds_min = {65535, 0, 0};
  east.bounds_max = {131070, 65535, 65535};
  NodeRecord detail = east;
  detail.parent = 2;
  detail.first_child = 0;
  detail.child_count = 0;
  detail.flags = kNodeDetail;
  detail.error_max_m = 0;
  index.nodes = {root, west, east, detail};
  return index;
}

TEST(Golden, WorldIndexVersion1) {
  static_assert(kWorldVersion == 1, "a new version needs a new file beside world_v1.zcw");
  const WorldIndex expected = make_index();
  const auto bytes = golden("world_v1.zcw", encode_world_index(expected));
  const auto index = decode_world_index(bytes, "world_v1.zcw");
  ASSERT_TRUE(index.ok()) << index.error().describe();
  EXPECT_EQ(index->header.anchor, expected.header.anchor);
  EXPECT_EQ(index->header.bounds_min, expected.header.bounds_min);
  EXPECT_EQ(index->header.bounds_max, expected.header.bounds_max);
  EXPECT_EQ(index->header.step_log2, -8);
  EXPECT_EQ(index->header.source_triangles, 1'000'000'007U);
  EXPECT_EQ(index->crs, expected.crs);
  ASSERT_EQ(index->nodes.size(), expected.nodes.size());
  for (std::size_t i = 0; i < expected.nodes.size(); ++i)
    EXPECT_EQ(std::memcmp(&index->nodes[i], &expected.nodes[i], sizeof(NodeRecord)), 0) << i;
  ASSERT_EQ(index->materials.size(), expected.materials.size());
  for (std::size_t i = 0; i < expected.materials.size(); ++i)
    EXPECT_EQ(std::memcmp(&index->materials[i], &expected.materials[i], sizeof(MaterialRecord)), 0) << i;
  EXPECT_EQ(node_file(index->nodes[3], "glb"), "zones/1/1_0.detail.glb");
}

TEST(Golden, BvhFileVersion1) {
  static_assert(BvhFileHeader{}.magic[3] == '1', "a new version needs a new file beside bvh_v1.zbvh");
  const BvhFile expected = make_bvh();
  const auto bytes = golden("bvh_v1.zbvh", encode_bvh_file(expected));
  const auto bvh = decode_bvh_file(bytes, "bvh_v1.zbvh");
  ASSERT_TRUE(bvh.ok()) << bvh.error().describe();
  EXPECT_EQ(bvh->depth, expected.depth);
  EXPECT_EQ(bvh->order, expected.order);
  ASSERT_EQ(bvh->nodes.size(), expected.nodes.size());
  EXPECT_EQ(std::memcmp(bvh->nodes.data(), expected.nodes.data(), expected.nodes.size() * sizeof(gpu::BvhNode)), 0);
}

TEST(Golden, PageVersion1) {
  static_assert(gpu::kPageMagic >> 24U == '1', "a new version needs a new file beside page_v1.bin");
  const auto page = assemble_page(make_mesh(), make_bvh(), make_node(), kMaterials, "page");
  ASSERT_TRUE(page.ok()) << page.error().describe();
  const auto view = std::as_bytes(std::span(*page));
  const auto bytes = golden("page_v1.bin", {view.begin(), view.end()});
  ASSERT_EQ(bytes.size(), 156U);
  std::vector<std::uint32_t> words(bytes.size() / 4);
  std::memcpy(words.data(), bytes.data(), bytes.size());
  EXPECT_TRUE(verify_page(words, kMaterials, "page_v1.bin").ok());
  gpu::PageHeader header;
  std::memcpy(&header, words.data(), sizeof header);
  EXPECT_EQ(header.node_count, 2U);
  EXPECT_EQ(header.triangle_count, 3U);
  EXPECT_EQ(header.depth, 2U);
  // The mesh's second triangle, which the order puts last: corners 3, 4, 5 and material 1.
  gpu::PageTriangle last;
  std::memcpy(&last, words.data() + header.triangle_offset_words + std::size_t{2} * gpu::kPageTriangleWords,
              sizeof last);
  EXPECT_EQ(last.v0_xy, pair(0, 512));
  EXPECT_EQ(last.v0_z_v1_x, pair(2, 65535));
  EXPECT_EQ(last.v1_yz, pair(40000, 300));
  EXPECT_EQ(last.v2_xy, pair(60000, 65535));
  EXPECT_EQ(last.v2_z_material, pair(65535, 1));
}

}  // namespace
}  // namespace zc
