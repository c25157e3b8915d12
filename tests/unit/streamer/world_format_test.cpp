// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <xxhash.h>

#include <cstring>
#include <random>

#include "shaders/shared/page_node.h"
#include "streamer/paging/memory_plan.h"
#include "streamer/paging/rendered_cut.h"
#include "streamer/streamer.h"
#include "streamer/world_format/bvh_page.h"
#include "streamer/world_format/page_view.h"
#include "streamer/world_format/world_index.h"
#include "tests/unit/streamer/tiny_world.h"

namespace zc {
namespace {

using test::make_tiny_world;
using test::TinyWorld;

const TinyWorld& world() {
  static const TinyWorld kWorld = make_tiny_world({.levels = 2, .detail = true});
  return kWorld;
}

// An exactly sized heap buffer, so that a sanitizer sees a read past its end.
std::vector<std::byte> prefix(const std::vector<std::byte>& bytes, std::size_t count) {
  return {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(count)};
}

void rehash(std::vector<std::byte>& bytes) {
  WorldHeader header;
  std::memcpy(&header, bytes.data(), sizeof header);
  header.body_xxh3 = XXH3_64bits(bytes.data() + sizeof header, bytes.size() - sizeof header);
  header.header_xxh3 = XXH3_64bits(&header, offsetof(WorldHeader, header_xxh3));
  std::memcpy(bytes.data(), &header, sizeof header);
}

// What a valid index promises to those who use it.
void use_index(const WorldIndex& index) {
  EXPECT_GT(smallest_cap_bytes(index), 0U);
  const std::vector<View> views(2);
  Selection selection;
  select_nodes(index,
               {.views = views, .limits = {.include_detail = true}, .budget_bytes = 1ULL << 40U, .tolerance = 1e-9},
               selection);
  EXPECT_LE(selection.nodes.size(), index.nodes.size());
  RenderedCut cover(index);
  for (const std::uint32_t n : selection.nodes) cover.add(n);
  EXPECT_LE(count_wanted(index, views, 1e-9, true, cover).missing, index.nodes.size());
  std::vector<std::uint32_t> cut;
  cover.collect(cut);
  EXPECT_LE(cut.size(), selection.nodes.size());
}

TEST(WorldIndex, has_no_room_for_a_reference_system_without_end) {
  std::vector<std::byte> bytes = encode_world_index(world().index);
  WorldHeader header;
  std::memcpy(&header, bytes.data(), sizeof header);
  header.crs_bytes = kMaxCrsBytes + 1;
  bytes.resize(bytes.size() - world().index.crs.size() + header.crs_bytes);
  std::memcpy(bytes.data(), &header, sizeof header);
  rehash(bytes);
  const auto index = decode_world_index(bytes, "world.zcw");
  ASSERT_FALSE(index.ok());
  EXPECT_NE(index.error().message.find("reference system is too long"), std::string::npos) << index.error().message;
}

TEST(WorldIndex, comes_back_as_it_was_written) {
  const WorldIndex& before = world().index;
  const std::vector<std::byte> bytes = encode_world_index(before);
  const Result<WorldIndex> after = decode_world_index(bytes, "world.zcw");
  ASSERT_TRUE(after.ok()) << after.error().describe();
  ASSERT_EQ(after->nodes.size(), before.nodes.size());
  EXPECT_EQ(std::memcmp(after->nodes.data(), before.nodes.data(), before.nodes.size() * sizeof(NodeRecord)), 0);
  EXPECT_EQ(after->materials.size(), 2U);
  EXPECT_EQ(after->crs, "EPSG:25832");
  EXPECT_EQ(encode_world_index(*after), bytes);
  EXPECT_DOUBLE_EQ(after->step_m(), 1.0 / 256);
}

TEST(WorldIndex, names_a_nodes_files_by_its_cell) {
  NodeRecord node;
  node.depth = 3;
  node.cell_x = 5;
  node.cell_y = 2;
  EXPECT_EQ(node_file(node, "glb"), "zones/3/5_2.glb");
  node.flags = kNodeDetail;
  EXPECT_EQ(node_file(node, "zbvh"), "zones/3/5_2.detail.zbvh");
}

TEST(WorldIndex, every_truncated_prefix_is_an_error) {
  const std::vector<std::byte> bytes = encode_world_index(world().index);
  for (std::size_t n = 0; n < bytes.size(); ++n) EXPECT_FALSE(decode_world_index(prefix(bytes, n), "w").ok()) << n;
}

TEST(WorldIndex, every_flipped_byte_is_an_error) {
  const std::vector<std::byte> good = encode_world_index(world().index);
  std::mt19937 random(7);
  for (int i = 0; i < 2000; ++i) {
    std::vector<std::byte> bytes = good;
    bytes[random() % bytes.size()] ^= static_cast<std::byte>(1 + random() % 255);
    EXPECT_FALSE(decode_world_index(bytes, "w").ok());
  }
}

TEST(WorldIndex, with_its_hashes_forged_is_an_error_or_usable) {
  const std::vector<std::byte> good = encode_world_index(world().index);
  std::mt19937 random(8);
  int accepted = 0;
  for (int i = 0; i < 4000; ++i) {
    std::vector<std::byte> bytes = good;
    for (std::uint32_t flips = 1 + static_cast<std::uint32_t>(random() % 2); flips > 0; --flips)
      bytes[12 + random() % (bytes.size() - 12)] ^= static_cast<std::byte>(1 + random() % 255);
    rehash(bytes);
    const Result<WorldIndex> index = decode_world_index(bytes, "w");
    if (!index.ok()) continue;
    ++accepted;
    use_index(*index);
  }
  EXPECT_GT(accepted, 0);
  EXPECT_LT(accepted, 3000);
}

TEST(WorldIndex, refuses_trees_that_are_none) {
  const auto refused = [](auto change) {
    WorldIndex index = world().index;
    change(index.nodes);
    return !decode_world_index(encode_world_index(index), "w").ok();
  };
  using Nodes = decltype(WorldIndex::nodes);
  EXPECT_FALSE(refused([](Nodes&) {}));
  EXPECT_TRUE(refused([](Nodes& n) { n[0].first_child = 0; }));
  EXPECT_TRUE(refused([](Nodes& n) { n[0].child_count = 0xFFFFFFFF; }));
  EXPECT_TRUE(refused([](Nodes& n) { n[1].parent = 2; }));
  EXPECT_TRUE(refused([](Nodes& n) { n[2].first_child = n[1].first_child; }));
  EXPECT_TRUE(refused([](Nodes& n) { n[1].page_bytes += 4; }));
  EXPECT_TRUE(refused([](Nodes& n) { n[1].bvh_bytes = 0; }));
  EXPECT_TRUE(refused([](Nodes& n) { n[1].reference_count = n[1].triangle_count - 1; }));
  EXPECT_TRUE(refused([](Nodes& n) { n[1].reference_count = 3 * n[1].triangle_count; }));
  EXPECT_TRUE(refused([](Nodes& n) { n[1].error_max_m = NAN; }));
  EXPECT_TRUE(refused([](Nodes& n) { n[1].bounds_max[0] = n[1].bounds_min[0] - 1; }));
  EXPECT_TRUE(refused([](Nodes& n) { n[1].flags = 8; }));
  EXPECT_TRUE(refused([](Nodes& n) { n.back().flags = 0, n[1].flags = kNodeDetail; }));
}

TEST(BvhFile, comes_back_and_refuses_prefixes_and_survives_flips) {
  const std::vector<std::byte>& good = world().files.at("zones/1/1_0.zbvh");
  const NodeRecord& record = world().index.nodes[2];
  Result<ZoneMesh> mesh = decode_zone_glb(world().files.at("zones/1/1_0.glb"), record, "g");
  ASSERT_TRUE(mesh.ok());
  const Result<BvhFile> bvh = decode_bvh_file(good, *mesh, record, "b");
  ASSERT_TRUE(bvh.ok()) << bvh.error().describe();
  EXPECT_EQ(encode_bvh_file(*bvh, *mesh, record).bytes, good);
  EXPECT_EQ(mesh->materials.front(), 0);
  EXPECT_EQ(mesh->materials.back(), 1);
  for (std::size_t n = 0; n < good.size(); ++n)
    EXPECT_FALSE(decode_bvh_file(prefix(good, n), *mesh, record, "b").ok()) << n;
  std::vector<std::byte> longer = good;
  longer.push_back(std::byte{0});
  EXPECT_FALSE(decode_bvh_file(longer, *mesh, record, "b").ok());

  std::mt19937 random(9);
  for (int i = 0; i < 2000; ++i) {
    std::vector<std::byte> bytes = good;
    bytes[random() % bytes.size()] ^= static_cast<std::byte>(1 + random() % 255);
    const Result<BvhFile> flipped = decode_bvh_file(bytes, *mesh, record, "b");
    if (!flipped.ok()) continue;
    const auto page = assemble_page(*mesh, *flipped, record, 2, "b");
    if (page.ok()) {
      EXPECT_TRUE(verify_page(*page, 2, "p").ok());
    }
  }
}

TEST(ZoneGlb, keeps_every_vertex) {
  const NodeRecord& record = world().index.nodes[1];
  const Result<ZoneMesh> mesh = decode_zone_glb(world().files.at("zones/1/0_0.glb"), record, "g");
  ASSERT_TRUE(mesh.ok()) << mesh.error().describe();
  EXPECT_EQ(mesh->triangles.size(), record.triangle_count);
  EXPECT_EQ(mesh->vertices.size(), record.vertex_count);
  std::uint16_t widest = 0;
  for (const auto& vertex : mesh->vertices) widest = std::max(widest, vertex[0]);
  EXPECT_EQ(widest, 1U << 14U);  // lossless: the ground ends exactly at the zone's border
}

TEST(ZoneGlb, prefixes_and_flips_are_errors_or_meshes_of_the_promised_size) {
  using Kind = test::TinyStream;
  for (const Kind kind : {Kind::kEdgebreaker, Kind::kSequential, Kind::kColored}) {
    NodeRecord record;
    const test::TinyZone zone = test::make_tiny_zone(3, 4, 1000, 5, record, kind);
    for (std::size_t n = 0; n < zone.glb.size(); ++n)
      EXPECT_FALSE(decode_zone_glb(prefix(zone.glb, n), record, "g").ok()) << n;
    std::mt19937 random(10);
    for (int i = 0; i < 2000; ++i) {
      std::vector<std::byte> bytes = zone.glb;
      bytes[random() % bytes.size()] ^= static_cast<std::byte>(1 + random() % 255);
      const Result<ZoneMesh> mesh = decode_zone_glb(bytes, record, "g");
      if (!mesh.ok()) continue;
      EXPECT_EQ(mesh->triangles.size(), record.triangle_count);
      EXPECT_LE(mesh->vertices.size(), record.vertex_count);
      for (const auto& triangle : mesh->triangles)
        for (const std::uint32_t corner : triangle) EXPECT_LT(corner, mesh->vertices.size());
    }
  }
}

TEST(ZoneGlb, deeply_nested_json_is_an_error) {
  NodeRecord record;
  const test::TinyZone zone = test::make_tiny_zone(2, 0, 1000, 5, record);
  std::vector<std::byte> bytes = zone.glb;
  std::uint32_t json_bytes = 0;
  std::memcpy(&json_bytes, bytes.data() + 12, 4);
  std::fill(bytes.begin() + 20, bytes.begin() + 20 + json_bytes, std::byte{'['});
  EXPECT_FALSE(decode_zone_glb(bytes, record, "g").ok());
}

TEST(Page, check_finds_wrong_boxes_references_depths_and_materials) {
  NodeRecord record;
  const test::TinyZone zone = test::make_tiny_zone(12, 60, 10000, 3, record);
  auto mesh = decode_zone_glb(zone.glb, record, "g");
  ASSERT_TRUE(mesh.ok());
  const auto bvh = decode_bvh_file(zone.bvh, *mesh, record, "b");
  ASSERT_TRUE(bvh.ok());
  const auto assembled = assemble_page(*mesh, *bvh, record, 2, "p");
  ASSERT_TRUE(assembled.ok());
  const std::vector<std::uint32_t>& good = *assembled;
  EXPECT_FALSE(verify_page(good, 1, "p").ok());  // material 1 does not exist
  const PageView view(good);
  const gpu::PageHeader header = view.header();
  ASSERT_GT(header.node_count, 8U);
  ASSERT_GT(header.cluster_count, 1U);
  const auto refused = [&](std::size_t word, std::uint32_t value) {
    std::vector<std::uint32_t> page = good;
    EXPECT_NE(page[word], value) << word;
    page[word] = value;
    return !verify_page(page, 2, "p").ok();
  };
  EXPECT_TRUE(refused(0, 0));            // magic
  EXPECT_TRUE(refused(1, 2));            // appearances that are not there
  EXPECT_TRUE(refused(1, 4));            // light that is not there
  EXPECT_TRUE(refused(1, 16));           // unknown flags
  EXPECT_TRUE(refused(2, good[2] - 1));  // a node more than it says
  EXPECT_TRUE(refused(8, good[8] - 1));  // depth
  EXPECT_TRUE(refused(8, good[8] + 1));  //
  EXPECT_TRUE(refused(10, 1));           // an atlas that is not there
  EXPECT_TRUE(refused(12, 1));           //
  EXPECT_TRUE(refused(13, 1));           // reserved
  const std::size_t root = PageView::node_word(0);
  EXPECT_TRUE(refused(root + 0, good[root] + 1000));           // boxes that leave out what they hold
  EXPECT_TRUE(refused(root + 3, good[root + 3] - 1));          //
  EXPECT_TRUE(refused(root + 4, 0));                           // a cycle
  EXPECT_TRUE(refused(root + 4, good[root + 4] + 1));          // between two nodes
  EXPECT_TRUE(refused(root + 4, 0xFFFFFFF0));                  // backwards
  EXPECT_TRUE(refused(root + 4, good[root + 4] + 20));         // a subtree left out
  EXPECT_TRUE(refused(root + 3, good[root + 3] ^ 1U << 16U));  // a child that is missing
  EXPECT_TRUE(refused(root + 3, good[root + 3] ^ 1U << 24U));  // both node and leaf
  std::uint32_t leafy = 0;
  while (leaf_mask(view.node(leafy)) == 0) ++leafy;
  const std::size_t leaf = PageView::node_word(leafy);
  EXPECT_TRUE(refused(leaf + 5, good[leaf + 5] + 1));  // another node's triangle
  EXPECT_TRUE(refused(leaf + 7, good[leaf + 7] + 4));  // no cluster's place
  EXPECT_TRUE(refused(leaf + 6, good[leaf + 6] + 1));  // a triangle too many
  EXPECT_TRUE(refused(leaf + 6, good[leaf + 6] | 9));  //
  const std::size_t cluster = view.entry(1).offset_words;
  EXPECT_TRUE(refused(cluster + 3, good[cluster + 3] - 8));    // vertices too few
  EXPECT_TRUE(refused(cluster + 3, good[cluster + 3] + 512));  // a triangle too many
  EXPECT_TRUE(refused(cluster + 4, 0x7FC00000));               // an error that is no number
  EXPECT_TRUE(refused(cluster + 5, good[cluster + 5] + 4));    // another page's start
  EXPECT_TRUE(refused(cluster + 6, good[cluster + 6] + 1));
  EXPECT_TRUE(refused(cluster + 7, good[cluster + 7] + 1000));        // palette
  EXPECT_TRUE(refused(cluster + 8, good[cluster + 8] | 0xFF));        // vertex 255
  EXPECT_TRUE(refused(cluster + 8, good[cluster + 8] | 0xFF000000));  // palette place 255
  EXPECT_TRUE(refused(header.entries_offset_words + 2, 0));           // cluster table
  EXPECT_TRUE(refused(header.palette_offset_words, 0x00020001));
}

// A box beyond 32 bits holds all that it should, and yet would come out empty where the top level reads it.
TEST(Page, check_finds_boxes_that_leave_the_lattice) {
  const std::vector<std::uint32_t> good = test::page_of(world(), 1);
  const gpu::PageNode root = PageView(good).node(0);
  const std::size_t word = PageView::node_word(0);
  for (const std::uint32_t exponent : {node_exponent(root, 2), 31U}) {
    std::vector<std::uint32_t> page = good;
    page[word + 3] |= exponent << 10;
    for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
      if (((inner_mask(root) | leaf_mask(root)) >> slot & 1U) == 0) continue;
      const std::uint32_t byte = 0xFFU << (8 * (slot & 3U));
      page[word + 12 + slot / 4] &= ~byte;  // from the node's origin
      page[word + 18 + slot / 4] |= byte;   // as far as the exponent reaches
    }
    EXPECT_EQ(verify_page(page, 2, "p").ok(), exponent != 31) << exponent;
  }
}

TEST(Page, flips_and_prefixes_are_errors_or_sound_pages) {
  const std::vector<std::uint32_t> good = test::page_of(world(), 1);
  for (std::size_t n = 0; n < good.size(); ++n) {
    const std::vector<std::uint32_t> cut(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(n));
    EXPECT_FALSE(verify_page(cut, 2, "p").ok()) << n;
  }
  std::mt19937 random(11);
  int accepted = 0;
  for (int i = 0; i < 2000; ++i) {
    std::vector<std::uint32_t> page = good;
    page[random() % page.size()] ^= 1U << random() % 32;
    accepted += verify_page(page, 2, "p").ok() ? 1 : 0;
  }
  EXPECT_LT(accepted, 2000);
}

}  // namespace
}  // namespace zc
