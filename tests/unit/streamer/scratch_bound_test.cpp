// SPDX-License-Identifier: Apache-2.0
// decode_scratch_bytes and decode_scratch_bound against what decoding really takes, counted by the executable's own
// operator new.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "streamer/world_format/bvh_page.h"
#include "tests/unit/counted_memory.h"
#include "tests/unit/streamer/tiny_world.h"

namespace zc {
namespace {

long long measure_decode(const test::TinyZone& zone, const NodeRecord& record) {
  return test::most_memory_of([&] {
    Result<ZoneMesh> mesh = decode_zone_glb(zone.glb, record, "g");
    EXPECT_TRUE(mesh.ok());
    Result<BvhFile> bvh = decode_bvh_file(zone.bvh, *mesh, record, "b");
    EXPECT_TRUE(bvh.ok());
    EXPECT_TRUE(assemble_page(*mesh, *bvh, record, 2, "p").ok());
  });
}

TEST(DecodeScratch, stays_below_its_bound_and_within_a_factor_of_it) {
  if (!test::kCountsMemory) GTEST_SKIP() << "AddressSanitizer's operator new counts nothing";
  const std::array<std::array<std::uint32_t, 2>, 11> shapes = {
      {{1, 0}, {1, 1}, {8, 2}, {20, 100}, {2, 2000}, {1, 20000}, {45, 0}, {150, 50}, {250, 10}, {30, 300}, {60, 600}}};
  using Kind = test::TinyStream;
  for (const Kind kind : {Kind::kEdgebreaker, Kind::kSequential, Kind::kColored}) {
    for (const auto& [grid, soup] : shapes) {
      NodeRecord record;
      const test::TinyZone zone = test::make_tiny_zone(grid, soup, 65535, 3, record, kind);
      const long long taken = measure_decode(zone, record);
      const auto bound = static_cast<long long>(record.scratch_bytes) + record.page_bytes;
      EXPECT_LE(record.scratch_bytes, decode_scratch_bound(record, record.glb_bytes));
      RecordProperty("bytes_per_triangle", std::to_string(taken / record.triangle_count));
      if (std::getenv("ZONECAST_PRINT") != nullptr)
        std::printf("%s %6u tri %6u vert %7llu glb: %9lld of %9lld, %.1f B/tri\n",
                    kind == Kind::kSequential ? "seq"
                    : kind == Kind::kColored  ? "color"
                                              : "edge",
                    record.triangle_count, record.vertex_count, static_cast<unsigned long long>(record.glb_bytes),
                    taken, bound, static_cast<double>(taken) / record.triangle_count);
      EXPECT_LE(taken, bound);
      if (record.triangle_count > 1000) {
        EXPECT_GE(taken * 5, bound);
      }
    }
  }
}

}  // namespace
}  // namespace zc
