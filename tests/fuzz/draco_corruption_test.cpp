// SPDX-License-Identifier: Apache-2.0
// A Draco stream with any random corruption is refused or gives triangles of its own vertices, in the memory that was
// promised for it: by itself, and in a zone's .glb whose hash is taken to be forged.
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <random>

#include "streamer/draco/mesh.h"
#include "streamer/world_format/bvh_page.h"
#include "tests/fuzz/fuzz_settings.h"
#include "tests/unit/counted_memory.h"
#include "tests/unit/streamer/draco_meshes.h"
#include "tests/unit/streamer/tiny_world.h"

namespace zc {
namespace {

using test::fuzz_seed;
using test::fuzz_tries;

class Damage {
 public:
  explicit Damage(std::uint64_t seed) : random_(seed) {}
  std::size_t below(std::size_t n) { return n == 0 ? 0 : static_cast<std::size_t>(random_() % n); }

  // Behind the first `intact` bytes.
  std::vector<std::byte> operator()(const std::vector<std::byte>& good, std::size_t intact) {
    std::vector<std::byte> bytes = good;
    for (std::size_t times = 1 + below(4); times > 0; --times) {
      const std::size_t most = below(3) == 0 ? std::min<std::size_t>(60, bytes.size() - intact) : bytes.size() - intact;
      const std::size_t at = intact + below(most);
      switch (below(4)) {
        case 0:
          bytes[at] ^= std::byte{1} << static_cast<int>(below(8));
          break;
        case 1:
          bytes[at] = static_cast<std::byte>(random_());
          break;
        case 2:
          bytes[at] = below(2) == 0 ? std::byte{0xFF} : std::byte{0};
          break;
        case 3:
          std::swap(bytes[at], bytes[intact + below(bytes.size() - intact)]);
          break;
      }
    }
    if (below(20) == 0) bytes.resize(intact + below(bytes.size() - intact));
    bytes.shrink_to_fit();
    return bytes;
  }

 private:
  std::mt19937_64 random_;
};

bool in_range(std::span<const std::array<std::uint32_t, 3>> triangles, std::size_t vertices) {
  return std::ranges::all_of(triangles, [&](const auto& triangle) {
    return std::ranges::all_of(triangle, [&](std::uint32_t corner) { return corner < vertices; });
  });
}

TEST(CorruptDraco, IsRefusedOrGivesTrianglesOfItsOwnVerticesWithoutMemory) {
  struct Stream {
    std::vector<std::byte> bytes;
    std::uint32_t position_id;
  };
  std::vector<Stream> streams;
  for (const test::HardMesh& mesh : test::HardMeshes(5).all()) {
    if (mesh.triangles.size() > 1500) continue;
    for (const test::DracoWay& way :
         {test::DracoWay{}, test::DracoWay{.speed = 5}, test::DracoWay{.speed = 5, .colors = test::Colors::kPlain},
          test::DracoWay{.edgebreaker = false}, test::DracoWay{.few_parallelograms = true}}) {
      const std::vector<std::byte> bytes = test::draco_stream(mesh, way);
      if (const test::DracoReading reading = test::read_with_draco(bytes); reading.ok)
        streams.push_back({bytes, reading.position_id});
    }
  }
  ASSERT_GT(streams.size(), 60U);
  Damage damage(fuzz_seed());
  std::uint64_t unread = 0;
  std::uint64_t refused = 0;
  std::uint64_t decoded = 0;
  for (std::uint64_t i = 0; i < fuzz_tries(); ++i) {
    const Stream& stream = streams[damage.below(streams.size())];
    const std::vector<std::byte> bad = damage(stream.bytes, 11);
    DracoLayout layout;
    if (read_draco_layout(bad, stream.position_id, layout) != nullptr || layout.faces > 100'000) {
      ++unread;
      continue;
    }
    ASSERT_LE(layout.scratch_words(), draco_scratch_words_most(layout.faces, layout.values, bad.size()));
    std::vector<std::array<std::uint16_t, 3>> vertices(layout.values);
    std::vector<std::array<std::uint32_t, 3>> triangles(layout.faces);
    std::vector<std::uint32_t> words(layout.scratch_words());
    bool ok = false;
    const long long taken = test::most_memory_of([&] { ok = decode_draco(layout, vertices, triangles, words); });
    ASSERT_EQ(taken, 0) << "try " << i;
    ASSERT_TRUE(!ok || in_range(triangles, vertices.size())) << "try " << i;
    ++(ok ? decoded : refused);
  }
  EXPECT_GT(unread, fuzz_tries() / 50);
  EXPECT_GT(refused, fuzz_tries() / 50);
  EXPECT_GT(decoded, fuzz_tries() / 50);
}

TEST(CorruptZoneGlb, TakesNoMoreMemoryThanItsRecordSays) {
  using Kind = test::TinyStream;
  struct Zone {
    test::TinyZone files;
    NodeRecord record;
  };
  std::vector<Zone> zones;
  for (const Kind kind : {Kind::kEdgebreaker, Kind::kSequential, Kind::kColored})
    for (const std::array<std::uint32_t, 2>& shape : {std::array{1U, 0U}, std::array{6U, 20U}, std::array{20U, 5U}}) {
      Zone zone;
      zone.files = test::make_tiny_zone(shape[0], shape[1], 65535, 3, zone.record, kind);
      zones.push_back(std::move(zone));
    }
  Damage damage(fuzz_seed());
  std::uint64_t decoded = 0;
  for (std::uint64_t i = 0; i < fuzz_tries(); ++i) {
    const Zone& zone = zones[damage.below(zones.size())];
    const std::vector<std::byte> bad = damage(zone.files.glb, 0);
    std::optional<Result<ZoneMesh>> mesh;
    const long long taken = test::most_memory_of([&] { mesh = decode_zone_glb(bad, zone.record, "g"); });
    ASSERT_LE(taken, zone.record.scratch_bytes) << "try " << i;
    if (!mesh->ok()) continue;
    ++decoded;
    ASSERT_EQ((*mesh)->triangles.size(), zone.record.triangle_count);
    ASSERT_TRUE(in_range((*mesh)->triangles, (*mesh)->vertices.size())) << "try " << i;
  }
  EXPECT_GT(decoded, 0U);
  EXPECT_LT(decoded, fuzz_tries());
}

}  // namespace
}  // namespace zc
