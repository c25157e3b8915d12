// SPDX-License-Identifier: GPL-3.0-or-later
// A `.zbvh` with any random corruption is an error, or makes a page of its zone's own triangles that is sound; the
// hashes that would have caught it before are taken to be forged.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <optional>
#include <random>

#include "streamer/world_format/page_view.h"
#include "tests/fuzz/baked_pages.h"
#include "tests/fuzz/page_audit.h"
#include "tests/unit/counted_memory.h"

namespace zc {
namespace {

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
        case 3:  // what comes last: looks, light, materials
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
  std::vector<std::byte> forge(const test::BakedZone& zone) {
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

// Gives a zone what this city has not: looks, normals here and there, an atlas.
void dress(test::BakedZone& zone, std::vector<std::uint32_t>& page, std::uint32_t material_count) {
  ZoneMesh mesh = zone.mesh;
  Result<BvhFile> bvh = decode_bvh_file(zone.bvh_file, mesh, zone.record, "b");
  ASSERT_TRUE(bvh.ok()) << bvh.error().describe();
  ZoneAppearance& appearance = bvh->appearance;
  for (std::uint32_t m = 0; m < material_count; ++m) {
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
  zone.record.page_bytes = 0;
  Result<std::vector<std::uint32_t>> dressed = assemble_page(mesh, *bvh, zone.record, material_count, "b");
  ASSERT_TRUE(dressed.ok()) << dressed.error().describe();
  const PageView::Parts parts = PageView(*dressed).parts();
  zone.record.page_bytes = static_cast<std::uint32_t>(4 * dressed->size());
  zone.record.appearance_bytes = parts.appearance_bytes;
  zone.record.light_bytes = parts.light_bytes;
  zone.record.normal_bytes = parts.normal_bytes;
  zone.record.texture_bytes = parts.texture_bytes;
  zone.bvh_file = encode_bvh_file(*bvh, mesh, zone.record).bytes;
  const Result<BvhFile> back = decode_bvh_file(zone.bvh_file, mesh, zone.record, "b");
  ASSERT_TRUE(back.ok()) << back.error().describe();
  const auto again = assemble_page(mesh, *back, zone.record, material_count, "b");
  ASSERT_TRUE(again.ok()) << again.error().describe();
  page = *again;
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
  Result<test::BakedPages> made = test::bake_pages(12, BvhMethod::kSbvh);
  ASSERT_TRUE(made.ok()) << made.error().describe();
  for (std::size_t z = 0; z < made->zones.size(); z += 2)
    ASSERT_NO_FATAL_FAILURE(dress(made->zones[z], made->pages[z], made->material_count));
  std::uint32_t flags = 0;  // every kind of page is there to damage
  for (const auto& page : made->pages) flags |= PageView(page).header().flags;
  ASSERT_EQ(flags, gpu::kPageFlags);
  std::vector<std::vector<std::array<PageView::Point, 3>>> expected;
  for (const auto& page : made->pages) expected.push_back(triangles_of(page));
  Bytes bytes(test::fuzz_seed());
  std::uint64_t undecoded = 0;
  std::uint64_t unassembled = 0;
  std::uint64_t accepted = 0;
  for (std::uint64_t i = 0; i < test::fuzz_tries(); ++i) {
    const std::size_t z = bytes.below(made->zones.size());
    const test::BakedZone& zone = made->zones[z];
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
    const auto page = assemble_page(mesh, *bvh, record, made->material_count, "b");
    if (!page.ok()) {
      ++unassembled;
      continue;
    }
    ++accepted;
    const auto fault = test::PageAudit(*page, 4096, made->material_count).run();
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
