// SPDX-License-Identifier: Apache-2.0
// The file formats, held to files made once: what is written today must equal them byte for byte, and reading them must
// give the values below. A test that fails here means a new format version, with a new file beside the old one. Event
// logs, too: one that fails there means that paging decides otherwise than before.
// ZONECAST_REWRITE_GOLDEN=1 writes the files.
#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "base/file.h"
#include "shaders/shared/page_node.h"
#include "streamer/paging/heap_page_sink.h"
#include "streamer/paging/memory_plan.h"
#include "streamer/streamer.h"
#include "streamer/world_format/bvh_page.h"
#include "streamer/world_format/page_view.h"
#include "streamer/world_format/world_index.h"
#include "tests/unit/same_bytes.h"
#include "tests/unit/streamer/tiny_world.h"

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

// A root with a leaf of two triangles and, below a second node, a leaf of one in a cluster of its own.
BvhFile make_bvh() {
  const NodeBox left{{0, 0, 0}, {256, 512, 2}};
  const NodeBox right{{0, 512, 2}, {65535, 65535, 65535}};
  BvhFile bvh;
  bvh.depth = 2;
  bvh.order = {0, 2, 1};
  bvh.clusters = {0, 2};
  gpu::PageNode root = pack_boxes(std::array<NodeBox, 8>{left, {}, {}, {}, {}, {}, right, {}});
  root.exponents_masks |= 1U << 24U | 1U << 22U;
  root.leaf_counts = 2;
  root.child_offset = 1;
  gpu::PageNode below = pack_boxes(std::array<NodeBox, 8>{NodeBox{}, {}, {}, right, {}, {}, {}, {}});
  below.exponents_masks |= 1U << 27U;
  below.leaf_counts = 1U << 12U;
  below.triangle_offset = 2;
  below.cluster_offset = 1;
  bvh.nodes = {root, below};

  // The ground from the atlas, seen from above, and the middle triangle in its own colour, with curved corners.
  ZoneAppearance& appearance = bvh.appearance;
  appearance.appearances = {{0U | gpu::kAppearanceTextured << 16U | 2U << 18U | 1U << 20U, 0xFFFD0004U},
                            {1U | gpu::kAppearanceColor << 16U, 0x00804020U}};
  appearance.appearance_of = {0, 1, 0};
  appearance.light = {{0x40FF8000U, 0x12345678U}, {0x00FFFFFFU, 0}, {0x00808080U, 0x00ABCDEFU}};
  appearance.curved = {1};
  appearance.normals = {{0x1FF7FDFFU, 0x3FEFF9FEU}};
  appearance.atlas_size = AtlasShape{3, 2, 1}.pack();
  appearance.texels_per_step = 0.0625F;
  appearance.atlas = {0x07E0F800U, 0x1B1B1B1BU, 0xFFFF0000U, 0xE4E4E4E4U};
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
  node.reference_count = 3;
  node.page_bytes = 4 * (16 + 2 * 20 + (16 + 4) + (8 + 1 + 5 + 2 + 2 + 2) + 4 + 4 + 4);
  node.scratch_bytes = 123456;
  node.primitive_count = 2;
  node.appearance_bytes = 2 * 8;
  node.light_bytes = 3 * 8;
  node.normal_bytes = 8;
  node.texture_bytes = 16;
  node.glb_bytes = 4321;
  node.bvh_bytes = 123;
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

TEST(Golden, WorldIndexVersion5) {
  static_assert(kWorldVersion == 5, "a new version needs a new file beside world_v5.zcw");
  const WorldIndex expected = make_index();
  const auto bytes = golden("world_v5.zcw", encode_world_index(expected));
  const auto index = decode_world_index(bytes, "world_v5.zcw");
  ASSERT_TRUE(index.ok()) << index.error().describe();
  EXPECT_EQ(index->header.anchor, expected.header.anchor);
  EXPECT_EQ(index->header.bounds_min, expected.header.bounds_min);
  EXPECT_EQ(index->header.bounds_max, expected.header.bounds_max);
  EXPECT_EQ(index->header.step_log2, -8);
  EXPECT_EQ(index->header.source_triangles, 1'000'000'007U);
  EXPECT_EQ(index->crs, expected.crs);
  ASSERT_EQ(index->nodes.size(), expected.nodes.size());
  for (std::size_t i = 0; i < expected.nodes.size(); ++i)
    EXPECT_TRUE(test::same_bytes(index->nodes[i], expected.nodes[i])) << i;
  ASSERT_EQ(index->materials.size(), expected.materials.size());
  for (std::size_t i = 0; i < expected.materials.size(); ++i)
    EXPECT_TRUE(test::same_bytes(index->materials[i], expected.materials[i])) << i;
  EXPECT_EQ(node_file(index->nodes[3], "glb"), "zones/1/1_0.detail.glb");
}

TEST(Golden, BvhFileVersion5) {
  static_assert(BvhFileHeader{}.magic[3] == '5', "a new version needs a new file beside bvh_v5.zbvh");
  const BvhFile expected = make_bvh();
  const NodeRecord node = make_node();
  const auto bytes = golden("bvh_v5.zbvh", encode_bvh_file(expected, make_mesh(), node).bytes);
  ZoneMesh mesh = make_mesh();
  mesh.materials.clear();
  const auto bvh = decode_bvh_file(bytes, mesh, node, "bvh_v5.zbvh");
  ASSERT_TRUE(bvh.ok()) << bvh.error().describe();
  EXPECT_EQ(bvh->depth, expected.depth);
  EXPECT_EQ(bvh->order, expected.order);
  ASSERT_EQ(bvh->nodes.size(), expected.nodes.size());
  EXPECT_EQ(bvh->clusters, expected.clusters);
  EXPECT_EQ(mesh.materials, make_mesh().materials);
  EXPECT_EQ(bvh->appearance.appearance_of, expected.appearance.appearance_of);
  EXPECT_EQ(std::memcmp(bvh->appearance.appearances.data(), expected.appearance.appearances.data(),
                        2 * sizeof(gpu::Appearance)),
            0);
  EXPECT_EQ(std::memcmp(bvh->appearance.light.data(), expected.appearance.light.data(), 3 * sizeof(gpu::TriangleLight)),
            0);
  EXPECT_EQ(bvh->appearance.curved, expected.appearance.curved);
  EXPECT_EQ(
      std::memcmp(bvh->appearance.normals.data(), expected.appearance.normals.data(), sizeof(gpu::TriangleNormals)), 0);
  EXPECT_EQ(bvh->appearance.atlas, expected.appearance.atlas);
  EXPECT_EQ(bvh->appearance.texels_per_step, 0.0625F);
  EXPECT_EQ(std::memcmp(bvh->nodes.data(), expected.nodes.data(), expected.nodes.size() * sizeof(gpu::PageNode)), 0);
}

TEST(Golden, PageVersion3) {
  static_assert(gpu::kPageMagic >> 24U == '3', "a new version needs a new file beside page_v3.bin");
  const auto page = assemble_page(make_mesh(), make_bvh(), make_node(), kMaterials, "page");
  ASSERT_TRUE(page.ok()) << page.error().describe();
  const auto now = std::as_bytes(std::span(*page));
  const auto bytes = golden("page_v3.bin", {now.begin(), now.end()});
  ASSERT_EQ(bytes.size(), make_node().page_bytes);
  std::vector<std::uint32_t> words(bytes.size() / 4);
  std::memcpy(words.data(), bytes.data(), bytes.size());
  EXPECT_TRUE(verify_page(words, kMaterials, "page_v3.bin").ok());
  const PageView view(words);
  EXPECT_EQ(view.header().node_count, 2U);
  EXPECT_EQ(view.header().triangle_count, 3U);
  EXPECT_EQ(view.header().cluster_count, 2U);
  EXPECT_EQ(view.header().depth, 2U);
  // The mesh's second triangle, which the order puts last: corners 3, 4, 5 and material 1.
  const PageView::Triangle last = view.triangle(2);
  EXPECT_EQ(last.corners[0], (PageView::Point{0, 512, 2}));
  EXPECT_EQ(last.corners[1], (PageView::Point{65535, 40000, 300}));
  EXPECT_EQ(last.corners[2], (PageView::Point{60000, 65535, 65535}));
  EXPECT_EQ(last.material, 1U);
  EXPECT_EQ(last.appearance.place, 0x00804020U);
  EXPECT_EQ(view.triangle(0).appearance.material, 0U | gpu::kAppearanceTextured << 16U | 2U << 18U | 1U << 20U);
  EXPECT_EQ(view.triangle(1).material, 0U);
}

// Every build type, compiler and sanitizer, and every number of threads: the same decisions.
TEST(Golden, EventLogs) {
  const test::TinyWorldOptions shape = {.levels = 4, .grid = 8, .soup = 10};
  const test::TinyWorld world = test::make_tiny_world(shape);
  const double size = test::tiny_world_size_m(shape);
  std::uint64_t pages = 0;
  for (const NodeRecord& node : world.index.nodes) pages += pool_bytes(node);
  const SinkCosts costs{.bytes_per_page = 112};  // what a sink takes is part of what fits
  std::string logs;
  for (const unsigned share : {100U, 50U, 25U, 12U}) {
    test::MemorySource source(world.files);
    source.remove(node_file(world.index.nodes[9], "glb"));
    HeapPageSink sink(costs);
    const StreamerOptions options = {.cap_bytes = smallest_cap_bytes(world.index, {}, costs) + pages * share / 100,
                                     .threads = 1 + share % 4,
                                     .source_latency_s = 0.05,
                                     .source_bandwidth_bytes_per_s = 2e5,
                                     .tolerance = 0.02};
    auto streamer = Streamer::open(source, options, sink);
    ASSERT_TRUE(streamer.ok()) << streamer.error().describe();
    for (int f = 0; f < 300; ++f) {
      std::vector<View> views;
      for (std::uint32_t ahead = 0; ahead < 4; ++ahead) {
        const double t = (f + 3.0 * ahead) / 300;
        views.push_back({{test::kTinyOrigin_m + size * (0.1 + 0.8 * t),
                          test::kTinyOrigin_m + size * (0.5 + 0.4 * (1 - 4 * t * (1 - t))), 2.0},
                         ahead});
      }
      ASSERT_TRUE((*streamer)->advance(views, f / 30.0).ok());
    }
    const StreamerStatistics s = (*streamer)->statistics();
    logs += std::to_string(share) + " % of the pages: " + s.event_log_xxh3 + ", " + std::to_string(s.zones_loaded) +
            " loaded, " + std::to_string(s.zones_evicted) + " evicted\n";
  }
  const auto* bytes = reinterpret_cast<const std::byte*>(logs.data());
  golden("event_logs.txt", std::vector<std::byte>(bytes, bytes + logs.size()));
}

}  // namespace
}  // namespace zc
