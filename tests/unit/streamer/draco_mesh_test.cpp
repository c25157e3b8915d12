// SPDX-License-Identifier: Apache-2.0
// decode_draco against libdraco, bit by bit.
#include "streamer/draco/mesh.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/streamer/draco_meshes.h"

namespace zc {
namespace {

// What the streams that were compared had.
struct Seen {
  int streams = 0;
  int by_valence = 0;
  int by_bits = 0;
  int split_events = 0;
  int splits = 0;
  int tagged = 0;
  int raw = 0;
  int large_tables = 0;
  int coded_indices = 0;
  int plain_indices = 0;
  int colored = 0;
  int closed = 0;

  void add(const DracoLayout& layout, bool has_colors) {
    ++streams;
    colored += has_colors ? 1 : 0;
    (layout.corrections.tagged ? tagged : raw) += 1;
    large_tables += layout.corrections.table_words() > 0 ? 1 : 0;
    if (!layout.edgebreaker) {
      (layout.coded_indices ? coded_indices : plain_indices) += 1;
      return;
    }
    (layout.by_valence ? by_valence : by_bits) += 1;
    split_events += layout.split_events > 0 ? 1 : 0;
    splits += layout.vertices > layout.values ? 1 : 0;
    closed += layout.faces > layout.symbols ? 1 : 0;
  }
};

// Whether the streamer can read it at all.
bool compare(const std::vector<std::byte>& stream, const test::DracoReading& expected, DracoLayout& layout) {
  if (read_draco_layout(stream, expected.position_id, layout) != nullptr) return false;
  EXPECT_EQ(layout.faces, expected.triangles.size());
  EXPECT_EQ(layout.values, expected.vertices.size());
  if (layout.faces != expected.triangles.size() || layout.values != expected.vertices.size()) return false;
  // Exactly as long: AddressSanitizer sees what goes beyond.
  std::vector<std::array<std::uint16_t, 3>> vertices(layout.values);
  std::vector<std::array<std::uint32_t, 3>> triangles(layout.faces);
  std::vector<std::uint32_t> words(layout.scratch_words(), 0xA5A5A5A5U);
  EXPECT_TRUE(decode_draco(layout, vertices, triangles, words));
  EXPECT_TRUE(vertices == expected.vertices);
  EXPECT_TRUE(triangles == expected.triangles);
  return true;
}

TEST(DracoMesh, hard_meshes_come_out_as_libdraco_gives_them) {
  Seen seen;
  for (const std::uint32_t seed : {1U, 2U})
    for (const test::HardMesh& mesh : test::HardMeshes(seed).all())
      for (const int speed : {3, 5, 7})
        for (const test::Colors colors : {test::Colors::kNone, test::Colors::kPredicted, test::Colors::kPlain})
          for (const int kind : {0, 1, 2}) {
            const test::DracoWay way = {kind != 0, speed, colors, kind == 2, speed == 5};
            const std::vector<std::byte> stream = test::draco_stream(mesh, way);
            if (stream.empty()) continue;
            const test::DracoReading expected = test::read_with_draco(stream);
            if (!expected.ok) continue;
            SCOPED_TRACE(mesh.name + ", " + std::to_string(mesh.triangles.size()) + " triangles, speed " +
                         std::to_string(speed) + ", kind " + std::to_string(kind) + ", colours " +
                         std::to_string(static_cast<int>(colors)));
            DracoLayout layout;
            const bool compared = compare(stream, expected, layout);
            // Colours may be of symbols without a length.
            EXPECT_TRUE(compared || colors != test::Colors::kNone);
            if (compared) seen.add(layout, colors != test::Colors::kNone);
            if (HasFailure()) return;
          }
  EXPECT_GT(seen.streams, 700);
  for (const int kind : {seen.by_valence, seen.by_bits, seen.split_events, seen.splits, seen.tagged, seen.raw,
                         seen.large_tables, seen.coded_indices, seen.plain_indices, seen.colored, seen.closed})
    EXPECT_GT(kind, 20);
}

// Every prefix is too short, or has all that counts.
TEST(DracoMesh, prefixes_are_refused_or_decode_to_the_same) {
  for (const test::HardMesh& mesh : test::HardMeshes(4).all()) {
    if (mesh.triangles.size() > 300) continue;
    for (const bool edgebreaker : {true, false}) {
      const std::vector<std::byte> stream = test::draco_stream(mesh, {.edgebreaker = edgebreaker});
      const test::DracoReading expected = test::read_with_draco(stream);
      if (!expected.ok) continue;
      for (std::size_t size = 0; size < stream.size(); ++size) {
        const std::vector<std::byte> prefix(stream.begin(), stream.begin() + static_cast<std::ptrdiff_t>(size));
        DracoLayout layout;
        EXPECT_FALSE(compare(prefix, expected, layout)) << mesh.name << ", " << size << " of " << stream.size();
      }
    }
  }
}

}  // namespace
}  // namespace zc
