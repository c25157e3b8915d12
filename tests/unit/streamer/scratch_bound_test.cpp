// SPDX-License-Identifier: Apache-2.0
// decode_scratch_bytes and decode_scratch_bound against what decoding really takes, counted by the executable's own
// operator new.
#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <new>

#include "streamer/world_format/bvh_page.h"
#include "tests/unit/streamer/tiny_world.h"

#ifndef __SANITIZE_ADDRESS__  // which replaces operator new itself

namespace {

std::atomic<long long> held_bytes{0};
std::atomic<long long> most_bytes{0};

void* take(std::size_t bytes) {
  void* memory = std::malloc(bytes == 0 ? 1 : bytes);
  if (memory == nullptr) throw std::bad_alloc();
  const long long now = held_bytes += static_cast<long long>(malloc_usable_size(memory));
  long long most = most_bytes;
  while (now > most && !most_bytes.compare_exchange_weak(most, now)) {
  }
  return memory;
}

void drop(void* memory) {
  if (memory == nullptr) return;
  held_bytes -= static_cast<long long>(malloc_usable_size(memory));
  std::free(memory);
}

}  // namespace

void* operator new(std::size_t bytes) { return take(bytes); }
void* operator new[](std::size_t bytes) { return take(bytes); }
void operator delete(void* memory) noexcept { drop(memory); }
void operator delete[](void* memory) noexcept { drop(memory); }
void operator delete(void* memory, std::size_t) noexcept { drop(memory); }
void operator delete[](void* memory, std::size_t) noexcept { drop(memory); }

namespace zc {
namespace {

long long measure_decode(const test::TinyZone& zone, const NodeRecord& record) {
  const long long before = held_bytes;
  most_bytes = before;
  {
    Result<ZoneMesh> mesh = decode_zone_glb(zone.glb, record, "g");
    Result<BvhFile> bvh = decode_bvh_file(zone.bvh, "b");
    EXPECT_TRUE(mesh.ok() && bvh.ok());
    EXPECT_TRUE(assemble_page(*mesh, *bvh, record, 2, "p").ok());
  }
  return most_bytes - before;
}

TEST(DecodeScratch, stays_below_its_bound_and_within_a_factor_of_it) {
  const std::array<std::array<std::uint32_t, 2>, 11> shapes = {
      {{1, 0}, {1, 1}, {8, 2}, {20, 100}, {2, 2000}, {1, 20000}, {45, 0}, {150, 50}, {250, 10}, {30, 300}, {60, 600}}};
  for (const bool sequential : {false, true}) {
    for (const auto& [grid, soup] : shapes) {
      NodeRecord record;
      const test::TinyZone zone = test::make_tiny_zone(grid, soup, 65535, 3, record, sequential);
      const long long taken = measure_decode(zone, record);
      const auto bound = static_cast<long long>(record.scratch_bytes) + record.page_bytes;
      EXPECT_LE(record.scratch_bytes,
                decode_scratch_bound(record, record.glb_bytes));
      RecordProperty("bytes_per_triangle", std::to_string(taken / record.triangle_count));
      if (std::getenv("ZONECAST_PRINT") != nullptr)
        std::printf("%s %6u tri %6u vert %7llu glb: %9lld of %9lld, %.1f B/tri\n", sequential ? "seq" : "edge",
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

#endif
