// SPDX-License-Identifier: Apache-2.0
// What the ledger says of a drive that is drawn, held against what the device and the allocator really handed out.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "replay/host/stand_in_host.h"
#include "streamer/paging/memory_plan.h"
#include "streamer/streamer.h"
#include "tests/unit/counted_memory.h"
#include "tests/unit/streamer/tiny_world.h"

namespace zc {
namespace {

constexpr test::TinyWorldOptions kShape = {.levels = 5, .grid = 8, .soup = 10};
constexpr std::uint32_t kWidth = 96;
constexpr std::uint32_t kHeight = 64;

const test::TinyWorld& world() {
  static const test::TinyWorld kWorld = test::make_tiny_world(kShape);
  return kWorld;
}

// The most that one part of the program takes from the allocator, leaving out what others take in between.
class HeapMeter {
 public:
  template <class Work>
  auto add(Work work) {
    const long long before = test::held_bytes;
    test::most_bytes = before;
    auto result = work();
    peak_ = std::max(peak_, held_ + test::most_bytes - before);
    held_ += test::held_bytes - before;
    return result;
  }
  [[nodiscard]] std::uint64_t peak() const { return static_cast<std::uint64_t>(peak_); }

 private:
  long long held_ = 0;
  long long peak_ = 0;
};

// A zone set, with what it takes from the allocator: all of it at once, while nothing else runs.
class MeteredSet final : public PageSink {
 public:
  MeteredSet(Device& device, bool staging) : zones(device, {.use_staging = staging}) {}
  [[nodiscard]] SinkCosts costs() const override { return zones.costs(); }
  Status create(std::uint64_t capacity_words, std::uint64_t max_pages) override {
    const long long before = test::held_bytes;
    ZC_TRY(zones.create(capacity_words, max_pages));
    heap_bytes = static_cast<std::uint64_t>(test::held_bytes - before);
    return {};
  }
  Status upload(std::uint64_t offset_words, std::span<const std::uint32_t> page) override {
    return zones.upload(offset_words, page);
  }
  Status move(std::uint64_t from_words, std::uint64_t to_words, std::uint64_t count_words) override {
    return zones.move(from_words, to_words, count_words);
  }
  void remove(std::uint64_t offset_words) override { zones.remove(offset_words); }
  Status show(std::span<const ShownPage> pages) override { return zones.show(pages); }

  ZoneSet zones;
  std::uint64_t heap_bytes = 0;
};

FrameCamera camera_at(const glm::dvec3& eye) {
  FrameCamera camera;
  camera.step_m = world().index.step_m();
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    camera.lattice[i] =
        static_cast<std::int32_t>(std::llround(eye[axis] / camera.step_m) - world().index.header.anchor[i]);
  }
  camera.right = {1, 0, 0};
  camera.up = {0, 0.6F, 0.8F};
  camera.forward = {0, 0.8F, -0.6F};
  return camera;
}

struct Drive {
  std::uint64_t cap = 0;
  StreamerStatistics paging;
  std::uint64_t device_bytes = 0;
  std::uint64_t heap_bytes = 0;      // of all
  std::uint64_t set_heap_bytes = 0;  // of the zone set
  std::uint64_t pages = 0;
  std::uint64_t coarse = 0;
  std::uint64_t drawn_pixels = 0;
};

// share: of all pages, beyond the smallest cap.
void drive(double share, bool staging, Drive& out) {
  auto device = Device::create({});  // validation layers would take memory of the same allocator
  ASSERT_TRUE(device.ok()) << device.error().describe();
  test::MemorySource source(world().files);
  const std::uint64_t device_before = (*device)->allocated_bytes();
  HeapMeter heap;
  std::optional<MeteredSet> sink;
  std::unique_ptr<Streamer> streamer;
  StreamerOptions options;
  std::uint64_t all_pages = 0;
  for (const NodeRecord& node : world().index.nodes) all_pages += pool_bytes(node);
  options.cap_bytes = out.cap =
      smallest_cap_bytes(world().index, {}, ZoneSet(**device, {.use_staging = staging}).costs()) +
      static_cast<std::uint64_t>(share * static_cast<double>(all_pages));
  options.tolerance = 0.004;
  options.max_in_flight = 6;
  const Status opened = heap.add([&]() -> Status {
    sink.emplace(**device, staging);
    ZC_ASSIGN(streamer, Streamer::open(source, options, *sink));
    return {};
  });
  ASSERT_TRUE(opened.ok()) << opened.error().describe();
  out.device_bytes = (*device)->allocated_bytes() - device_before;

  const ZoneSet& zones = sink->zones;
  HostOptions drawing;
  drawing.width = kWidth;
  drawing.height = kHeight;
  drawing.reflections = ReflectionMode::kProxy;
  const std::vector<gpu::MaterialEntry> materials(2, {0.5F, 0.5F, 0.5F, 0.1F, 0, 0, 0, 0});
  auto renderer = StandInHost::create(**device, zones, zones, materials, drawing);
  ASSERT_TRUE(renderer.ok()) << renderer.error().describe();
  const std::uint64_t device_after = (*device)->allocated_bytes();
  const double size = test::tiny_world_size_m(kShape);
  for (int f = 0; f < 120; ++f) {
    const double t = f / 20.0;
    const View view{{test::kTinyOrigin_m + size * (0.5 + 0.45 * std::cos(t)),
                     test::kTinyOrigin_m + size * (0.5 + 0.45 * std::sin(2 * t)), 40.0}};
    const Status advanced = heap.add([&] { return streamer->advance(std::span(&view, 1), f / 30.0); });
    ASSERT_TRUE(advanced.ok()) << advanced.error().describe();
    out.pages = std::max<std::uint64_t>(out.pages, streamer->statistics().frame.resident_nodes);
    if (f % 10 != 0) continue;
    std::vector<ZoneDraw> draws;
    for (std::uint32_t slot = 0; slot < zones.zone_count(); ++slot)
      draws.push_back({slot, zones.triangle_count(slot), 0});
    const auto frame = (*renderer)->render(camera_at(view.eye), draws);
    ASSERT_TRUE(frame.ok()) << frame.error().describe();
    out.drawn_pixels += frame->counters.pixel_count;
  }
  out.paging = streamer->statistics();
  out.heap_bytes = heap.peak();
  out.set_heap_bytes = sink->heap_bytes;
  EXPECT_EQ((*device)->allocated_bytes(), device_after) << "drawing took memory of the device";
}

std::uint64_t peak_of(const StreamerStatistics& paging, LedgerClass part) {
  return paging.ledger_classes[static_cast<std::size_t>(part)].peak_bytes;
}

TEST(DrawingMemory, IsNeverMoreThanTheLedgerSays) {
  if (!test::kCountsMemory) GTEST_SKIP() << "AddressSanitizer's operator new counts nothing";
  std::printf("%10s %7s %5s %7s %10s %10s %10s %10s %10s %10s\n", "cap", "staging", "pages", "evicted", "ledger",
              "pool+set", "device", "set heap", "heap", "all taken");
  for (const bool staging : {false, true}) {
    for (const double share : {0.1, 0.4, 2.0}) {
      SCOPED_TRACE(share);
      Drive one;
      drive(share, staging, one);
      if (HasFatalFailure()) return;
      const std::uint64_t ledger = one.paging.ledger.peak_bytes;
      const std::uint64_t drawing =
          peak_of(one.paging, LedgerClass::kPool) + peak_of(one.paging, LedgerClass::kTopLevel);
      const std::uint64_t taken = one.device_bytes + one.heap_bytes;
      std::printf("%10lu %7s %5lu %7lu %10lu %10lu %10lu %10lu %10lu %10lu\n", one.cap, staging ? "yes" : "no",
                  one.pages, one.paging.zones_evicted, ledger, drawing, one.device_bytes, one.set_heap_bytes,
                  one.heap_bytes, taken);
      EXPECT_LE(ledger, one.cap);
      EXPECT_LE(one.device_bytes + one.set_heap_bytes, drawing);
      EXPECT_LE(taken, ledger);
      // Nor is the ledger all air, beside the streamer's own fixed part.
      EXPECT_GE(one.device_bytes + one.set_heap_bytes, drawing / 10 * 9);
      EXPECT_GE(taken + kFixedStateBytes, ledger / 10 * 7);
      EXPECT_GT(one.drawn_pixels, 0U);
      EXPECT_GT(one.paging.zones_loaded, 10U);
    }
  }
}

}  // namespace
}  // namespace zc
