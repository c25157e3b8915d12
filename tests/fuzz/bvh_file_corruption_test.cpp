// SPDX-License-Identifier: GPL-3.0-or-later
// A `.zbvh` with any random corruption is an error, or makes a page of its zone's own triangles that is sound; the
// hashes that would have caught it before are taken to be forged.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <random>

#include "streamer/world_format/page_view.h"
#include "tests/fuzz/baked_pages.h"
#include "tests/fuzz/page_audit.h"

namespace zc {
namespace {

class Bytes {
 public:
  explicit Bytes(std::uint64_t seed) : random_(seed) {}
  std::size_t below(std::size_t n) { return n == 0 ? 0 : static_cast<std::size_t>(random_() % n); }

  std::vector<std::byte> damage(const std::vector<std::byte>& good, const BvhFileHeader& header) {
    std::vector<std::byte> bytes = good;
    const std::size_t nodes = sizeof header;
    const std::size_t order = nodes + sizeof(gpu::PageNode) * header.node_count;
    const std::size_t clusters = order + sizeof(std::uint32_t) * header.reference_count;
    for (std::size_t times = below(4) != 0 ? 1 : 2 + below(3); times > 0; --times) {
      switch (below(11)) {
        case 0:
          flip(bytes, 0, nodes);
          break;
        case 1:
          flip(bytes, nodes, order);
          break;
        case 2:
          flip(bytes, order, clusters);
          break;
        case 3:
          flip(bytes, clusters, bytes.size());
          break;
        case 4:
          put(bytes, 4 * below(bytes.size() / 4), awkward());
          break;
        case 5: {  // child, triangles, counts or cluster of a node, off by little
          const std::size_t field = 4 + below(4);
          add(bytes, nodes + sizeof(gpu::PageNode) * below(header.node_count) + 4 * field);
          break;
        }
        case 6:
          add(bytes, order + 4 * below(header.reference_count));
          break;
        case 7:
          add(bytes, clusters + 4 * below(header.cluster_count));
          break;
        case 8:
          swap(bytes, nodes, sizeof(gpu::PageNode), header.node_count);
          break;
        case 9:
          swap(bytes, order, sizeof(std::uint32_t), header.reference_count);
          break;
        case 10:
          add(bytes, 4 * (1 + below(5)));
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
        for (std::size_t i = below(2) == 0 ? 0 : nodes; i < bytes.size(); ++i) bytes[i] = std::byte(random_() & 0xFFU);
        break;
      default:
        break;
    }
    bytes.shrink_to_fit();
    return bytes;
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

// Of a page, in no order: the corners of its triangles, each once.
std::vector<std::array<PageView::Point, 3>> triangles_of(std::span<const std::uint32_t> page) {
  const PageView view(page);
  std::vector<std::array<PageView::Point, 3>> triangles(view.header().triangle_count);
  for (std::uint32_t t = 0; t < triangles.size(); ++t) triangles[t] = view.triangle(t).corners;
  std::ranges::sort(triangles);
  triangles.erase(std::ranges::unique(triangles).begin(), triangles.end());
  return triangles;
}

TEST(CorruptBvhFile, IsAnErrorOrMakesASoundPageOfTheSameTriangles) {
  const Result<test::BakedPages> made = test::bake_pages(12);
  ASSERT_TRUE(made.ok()) << made.error().describe();
  std::vector<std::vector<std::array<PageView::Point, 3>>> expected;
  for (const auto& page : made->pages) expected.push_back(triangles_of(page));
  Bytes bytes(test::fuzz_seed());
  std::uint64_t undecoded = 0;
  std::uint64_t unassembled = 0;
  std::uint64_t accepted = 0;
  for (std::uint64_t i = 0; i < test::fuzz_tries(); ++i) {
    const std::size_t z = bytes.below(made->zones.size());
    const test::BakedZone& zone = made->zones[z];
    BvhFileHeader header;
    std::memcpy(&header, zone.bvh_file.data(), sizeof header);
    std::vector<std::byte> bad = bytes.damage(zone.bvh_file, header);
    while (bad == zone.bvh_file) bad = bytes.damage(zone.bvh_file, header);
    const Result<BvhFile> bvh = decode_bvh_file(bad, "b");
    if (!bvh.ok()) {
      ++undecoded;
      continue;
    }
    // Half of the indices were forged with the file and describe what it says.
    NodeRecord record = zone.record;
    if (bytes.below(2) == 0) {
      record.page_bytes = 0;
      record.bvh_node_count = static_cast<std::uint32_t>(bvh->nodes.size());
      record.bvh_depth = bvh->depth;
      record.reference_count = static_cast<std::uint32_t>(bvh->order.size());
    }
    const auto page = assemble_page(zone.mesh, *bvh, record, made->material_count, "b");
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
