// SPDX-License-Identifier: GPL-3.0-or-later
// A `.zbvh` with any random corruption is an error, or makes a page of its zone's own triangles that is sound; the
// hashes that would have caught it before are taken to be forged.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <optional>
#include <random>

#include "baker/bvh/build_page.h"
#include "streamer/world_format/page_view.h"
#include "tests/fuzz/fuzz_settings.h"
#include "tests/fuzz/page_audit.h"
#include "tests/unit/counted_memory.h"
#include "tests/unit/streamer/tiny_world.h"

namespace zc {
namespace {

constexpr std::uint32_t kMaterials = 5;

struct Zone {
  NodeRecord record;
  std::vector<std::byte> bvh_file;
  ZoneMesh mesh;  // without materials
  std::vector<std::uint32_t> page;
};

class Bytes {
 public:
  explicit Bytes(std::uint64_t seed) : random_(seed) {}
  std::size_t below(std::size_t n) { return n == 0 ? 0 : static_cast<std::size_t>(random_() % n); }

  std::vector<std::byte> damage(const std::vector<std::byte>& good) {
    std::vector<std::byte> bytes = good;
    const std::size_t coded = sizeof(BvhFileHeader);
    for (std::size_t times = below(4) != 0 ? 1 : 2 + below(3); times > 0; --times) {
      switch (below(7)) {
        case 0:
          flip(bytes, 0, coded);
          break;
        case 1:  // the tree, or what comes first of it
          flip(bytes, coded, coded + 1 + (bytes.size() - coded) / 4);
          break;
        case 2:
          flip(bytes, coded, bytes.size());
          break;
        case 3:  // what comes last: appearances, light, materials
          flip(bytes, bytes.size() - 1 - below(40), bytes.size());
          break;
        case 4:
          put(bytes, below(bytes.size() - 4), awkward());
          break;
        case 5:
          add(bytes, 4 * below(coded / 4));
          break;
        case 6:
          swap(bytes, coded, 4, (bytes.size() - coded) / 4);
          break;
      }
    }
    switch (below(16)) {
      case 0:
        bytes.resize(below(bytes.size()));
        break;
      case 1:
        bytes.resize(bytes.size() + 1 + below(100));
        break;
      case 2:
        for (std::size_t i = below(2) == 0 ? 0 : coded; i < bytes.size(); ++i) bytes[i] = std::byte(random_() & 0xFFU);
        break;
      case 3:  // any symbols from some place on
        for (std::size_t i = coded + below(bytes.size() - coded); i < bytes.size(); ++i)
          bytes[i] = std::byte(random_() & 0xFFU);
        break;
      default:
        break;
    }
    bytes.shrink_to_fit();
    return bytes;
  }

  // Well coded, but what it says is wrong.
  std::vector<std::byte> forge(const Zone& zone) {
    ZoneMesh mesh = zone.mesh;
    Result<BvhFile> decoded = decode_bvh_file(zone.bvh_file, mesh, zone.record, "b");
    EXPECT_TRUE(decoded.ok());
    BvhFile bvh = *std::move(decoded);
    for (std::size_t times = 1 + below(3); times > 0; --times) {
      switch (below(7)) {
        case 0: {  // two clusters as one
          if (bvh.clusters.size() < 2) break;
          const auto gone = static_cast<std::uint32_t>(1 + below(bvh.clusters.size() - 1));
          bvh.clusters.erase(bvh.clusters.begin() + gone);
          for (gpu::PageNode& node : bvh.nodes) node.cluster_offset -= node.cluster_offset >= gone ? 1 : 0;
          break;
        }
        case 1:  // a material that there is or is not
          mesh.materials[below(mesh.materials.size())] =
              static_cast<std::uint16_t>(below(2) == 0 ? below(8) : random_());
          break;
        case 2:
          if (!bvh.trims.empty())
            bvh.trims[below(bvh.trims.size())][below(6)] = static_cast<std::uint8_t>(below(kLeafTrimParts));
          break;
        case 3:  // sound, though slow to trace
          if (!bvh.split) std::swap(bvh.order[below(bvh.order.size())], bvh.order[below(bvh.order.size())]);
          break;
        case 4:
          if (!bvh.appearance.light.empty())
            bvh.appearance.light[below(bvh.appearance.light.size())].bounce ^= 1U << below(32);
          break;
        case 5:
          if (!bvh.appearance.appearances.empty())
            bvh.appearance.appearances[below(bvh.appearance.appearances.size())].material ^= 1U << below(31);
          break;
        case 6:
          if (!bvh.appearance.appearance_of.empty())
            bvh.appearance.appearance_of[below(bvh.appearance.appearance_of.size())] =
                static_cast<std::uint16_t>(below(bvh.appearance.appearances.size()));
          break;
      }
    }
    return encode_bvh_file(bvh, mesh, zone.record).bytes;
  }

 private:
  void flip(std::vector<std::byte>& bytes, std::size_t from, std::size_t to) {
    const std::size_t at = from + below(to - from);
    bytes[at] ^= std::byte(1U << below(8));
  }
  void put(std::vector<std::byte>& bytes, std::size_t at, std::uint32_t value) {
    std::memcpy(bytes.data() + at, &value, sizeof value);
  }
  void add(std::vector<std::byte>& bytes, std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    put(bytes, at, below(2) == 0 ? value + 1 : value - 1);
  }
  void swap(std::vector<std::byte>& bytes, std::size_t from, std::size_t size, std::size_t count) {
    const auto a = bytes.begin() + static_cast<std::ptrdiff_t>(from + size * below(count));
    const auto b = bytes.begin() + static_cast<std::ptrdiff_t>(from + size * below(count));
    if (a != b) std::swap_ranges(a, a + static_cast<std::ptrdiff_t>(size), b);
  }
  std::uint32_t awkward() {
    constexpr std::array<std::uint32_t, 10> values = {0,          1,          0xFF,       0xFFFF,     0x10000,
                                                      0x00FFFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFE, 0xFFFFFFFF};
    return values[below(values.size())];
  }

  std::mt19937_64 random_;
};

// Light that changes now and then from triangle to triangle.
std::vector<gpu::TriangleLight> light_of(std::size_t triangles) {
  std::vector<gpu::TriangleLight> light;
  for (std::uint32_t t = 0; t < triangles; ++t)
    light.push_back({0x40606080U + t / 9 * 0x05020301U, 0x2108421U * (t / 23) ^ t / 40 << 24U});
  return light;
}

// Appearances, normals here and there, and an atlas.
void add_appearances(const ZoneMesh& mesh, ZoneAppearance& appearance) {
  for (std::uint32_t m = 0; m < kMaterials; ++m) {
    appearance.appearances.push_back({m | gpu::kAppearanceTextured << 16U | 2U << 18U | 1U << 20U, 0xFFFD0004U + m});
    appearance.appearances.push_back({m | gpu::kAppearanceColor << 16U, 0x00804020U + m});
  }
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    appearance.appearance_of.push_back(static_cast<std::uint16_t>(2 * mesh.materials[t] + (t / 5 % 3 == 0 ? 0 : 1)));
    if (t % 7 > 3) continue;
    appearance.curved.push_back(t);
    appearance.normals.push_back({t * 2654435761U & 0x3FFFFFFFU, t * 40503U & 0x3FFFFFFFU});
  }
  appearance.atlas_size = AtlasShape{3, 2, 1}.pack();
  appearance.texels_per_step = 0.0625F;
  appearance.atlas = {0x07E0F800U, 0x1B1B1B1BU, 0xFFFF0000U, 0xE4E4E4E4U};
}

// Ground and loose triangles, as a bake would write them: a tree that splits triangles, materials in runs.
Result<Zone> make_zone(std::uint32_t grid, std::uint32_t soup, std::uint32_t seed, bool has_appearances) {
  Zone zone;
  const test::TinyZone files = test::make_tiny_zone(grid, soup, 65535, seed, zone.record);
  ZC_ASSIGN(ZoneMesh mesh, decode_zone_glb(files.glb, zone.record, "z"));
  zone.mesh = mesh;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    mesh.materials.push_back(static_cast<std::uint16_t>(t / 12 * 7 % kMaterials));
  ZoneAppearance appearance;
  appearance.light = light_of(mesh.triangles.size());
  if (has_appearances) add_appearances(mesh, appearance);
  BvhBuildOptions options;
  options.method = BvhMethod::kSbvh;
  ZC_ASSIGN(const BuiltPage built, build_page(mesh, appearance, options, kMaterials, zone.record, "z"));
  zone.bvh_file = encode_bvh_file(built.bvh, mesh, zone.record).bytes;
  ZC_ASSIGN(const BvhFile back, decode_bvh_file(zone.bvh_file, mesh, zone.record, "z"));
  ZC_ASSIGN(zone.page, assemble_page(mesh, back, zone.record, kMaterials, "z"));
  return zone;
}

// Of a page, in no order: the corners of its triangles, each once.
std::vector<std::array<PageView::Point, 3>> triangles_of(std::span<const std::uint32_t> page) {
  const PageView view(page);
  std::vector<std::array<PageView::Point, 3>> triangles(view.header().triangle_count);
  for (std::uint32_t t = 0; t < triangles.size(); ++t) triangles[t] = view.triangle(t).corners;
  std::ranges::sort(triangles);
  triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
  return triangles;
}

TEST(CorruptBvhFile, IsAnErrorOrMakesASoundPageOfTheSameTriangles) {
  std::vector<Zone> zones;
  std::vector<std::vector<std::array<PageView::Point, 3>>> expected;
  std::uint32_t flags = 0;
  for (const auto& [grid, soup] : {std::pair{1U, 0U}, {3U, 9U}, {8U, 0U}, {8U, 60U}, {12U, 30U}, {20U, 200U}})
    for (const bool has_appearances : {false, true}) {
      Result<Zone> zone = make_zone(grid, soup, grid + soup, has_appearances);
      ASSERT_TRUE(zone.ok()) << zone.error().describe();
      flags |= PageView(zone->page).header().flags;
      expected.push_back(triangles_of(zone->page));
      zones.push_back(*std::move(zone));
    }
  ASSERT_EQ(flags, gpu::kPageFlags);  // every kind of page is there to damage
  Bytes bytes(test::fuzz_seed());
  std::uint64_t undecoded = 0;
  std::uint64_t unassembled = 0;
  std::uint64_t accepted = 0;
  for (std::uint64_t i = 0; i < test::fuzz_tries(); ++i) {
    const std::size_t z = bytes.below(zones.size());
    const Zone& zone = zones[z];
    std::vector<std::byte> bad = bytes.below(4) == 0 ? bytes.forge(zone) : bytes.damage(zone.bvh_file);
    while (bad == zone.bvh_file) bad = bytes.damage(zone.bvh_file);
    // Half of the indices were forged with the file and describe what it says, whatever that is.
    NodeRecord record = zone.record;
    const bool forged = bytes.below(2) == 0;
    if (forged) {
      record.bvh_node_count *= 2;
      record.reference_count *= 2;
      record.bvh_depth = gpu::kPageMaxDepth;
    }
    ZoneMesh mesh = zone.mesh;
    std::optional<Result<BvhFile>> decoded;
    const long long taken = test::most_memory_of([&] { decoded = decode_bvh_file(bad, mesh, record, "b"); });
    ASSERT_LE(taken, page_scratch_bytes(record, mesh.vertices.size())) << "try " << i;
    const Result<BvhFile>& bvh = *decoded;
    if (!bvh.ok()) {
      ++undecoded;
      continue;
    }
    if (forged) {
      record.page_bytes = 0;
      record.bvh_node_count = static_cast<std::uint32_t>(bvh->nodes.size());
      record.bvh_depth = bvh->depth;
      record.reference_count = static_cast<std::uint32_t>(bvh->order.size());
    }
    const auto page = assemble_page(mesh, *bvh, record, kMaterials, "b");
    if (!page.ok()) {
      ++unassembled;
      continue;
    }
    ++accepted;
    const auto fault = test::PageAudit(*page, 4096, kMaterials).run();
    ASSERT_FALSE(fault.has_value()) << "try " << i << ": " << *fault;
    ASSERT_EQ(triangles_of(*page), expected[z]) << "try " << i;
  }
  std::printf("seed %llu: %llu not decoded, %llu not assembled, %llu accepted\n",
              static_cast<unsigned long long>(test::fuzz_seed()), static_cast<unsigned long long>(undecoded),
              static_cast<unsigned long long>(unassembled), static_cast<unsigned long long>(accepted));
  EXPECT_GT(undecoded, test::fuzz_tries() / 50);
  EXPECT_GT(unassembled, test::fuzz_tries() / 50);
  EXPECT_GT(accepted, test::fuzz_tries() / 500);
}

}  // namespace
}  // namespace zc
