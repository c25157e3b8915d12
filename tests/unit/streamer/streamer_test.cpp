// SPDX-License-Identifier: Apache-2.0
#include "streamer/streamer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <thread>

#include "streamer/paging/heap_page_sink.h"
#include "streamer/paging/memory_plan.h"
#include "streamer/statistics/belady.h"
#include "streamer/world_format/bvh_page.h"
#include "tests/unit/streamer/tiny_world.h"

namespace zc {
namespace {

using test::MemorySource;
using test::TinyWorld;
using test::TinyWorldOptions;

constexpr TinyWorldOptions kShape = {.levels = 4, .grid = 8, .soup = 10};

const TinyWorld& world() {
  static const TinyWorld kWorld = test::make_tiny_world(kShape);
  return kWorld;
}

// A round through the world, `t` in 0..1.
View view_at(double t) {
  const double size = test::tiny_world_size_m(kShape);
  const double angle = 6.283185307 * t;
  return {{test::kTinyOrigin_m + size * (0.5 + 0.45 * std::cos(angle)),
           test::kTinyOrigin_m + size * (0.5 + 0.45 * std::sin(2 * angle)), 2.0}};
}

constexpr int kFrames = 240;

Status drive(Streamer& streamer, const std::function<void(int)>& each_frame = {}) {
  for (int f = 0; f < kFrames; ++f) {
    std::vector<View> views;
    for (std::uint32_t ahead = 0; ahead < 4; ++ahead) {
      views.push_back(view_at((f + 3.0 * ahead) / kFrames));
      views.back().steps_ahead = ahead;
    }
    ZC_TRY(streamer.advance(views, f / 30.0));
    if (each_frame) each_frame(f);
  }
  return {};
}

// A cap that leaves `share` of what all pages take beyond the smallest.
std::uint64_t cap_for(double share) {
  std::uint64_t pages = 0;
  for (const NodeRecord& node : world().index.nodes) pages += pool_bytes(node);
  return smallest_cap_bytes(world().index) + static_cast<std::uint64_t>(share * static_cast<double>(pages));
}

StreamerOptions options_for(std::uint64_t cap) {
  return {.cap_bytes = cap,
          .threads = 2,
          .source_latency_s = 0.05,
          .source_bandwidth_bytes_per_s = 2e5,
          .tolerance = 0.02,
          .max_in_flight = 6};
}

// Every page of the rendered cut lies where the streamer says, whole, and the rendered cut covers each leaf once.
void check_cut(const Streamer& streamer, const HeapPageSink& sink) {
  const IndexView index = streamer.index();
  std::vector<int> times(index.nodes.size());
  for (const std::uint32_t n : streamer.rendered_cut()) {
    ASSERT_TRUE(streamer.resident(n));
    const std::vector<std::uint32_t> page = test::page_of(world(), n);
    const auto held = sink.words().subspan(streamer.page_offset_words(n), page.size());
    ASSERT_TRUE(std::equal(page.begin(), page.end(), held.begin())) << n;
    ++times[n];
  }
  for (std::size_t n = 1; n < index.nodes.size(); ++n)
    times[n] += times[static_cast<std::size_t>(index.nodes[n].parent)];
  for (std::size_t n = 0; n < index.nodes.size(); ++n)
    if (index.nodes[n].child_count == 0) {
      ASSERT_EQ(times[n], 1);
    }
}

TEST(Streamer, event_log_is_the_same_at_any_thread_count) {
  for (const double share : {0.6, 1.0}) {
    std::string expected;
    std::uint64_t loaded = 0;
    for (const unsigned threads : {1U, 2U, 4U, 8U, 1U}) {
      MemorySource source(world().files);
      source.remove(node_file(world().index.nodes[7], "glb"));
      HeapPageSink sink;
      StreamerOptions options = options_for(cap_for(share));
      options.threads = threads;
      auto streamer = Streamer::open(source, options, sink);
      ASSERT_TRUE(streamer.ok()) << streamer.error().describe();
      ASSERT_TRUE(drive(**streamer).ok());
      const StreamerStatistics s = (*streamer)->statistics();
      if (expected.empty()) {
        expected = s.event_log_xxh3;
        loaded = s.zones_loaded;
        EXPECT_GT(s.zones_loaded, 10U);
        EXPECT_GT(s.requests.failed, 0U);
      }
      EXPECT_EQ(s.event_log_xxh3, expected) << threads;
      EXPECT_EQ(s.zones_loaded, loaded);
    }
  }
}

// What it takes of memory: paging_memory_test.cpp.
TEST(Streamer, at_any_cap_always_covers_the_world_with_whole_pages) {
  std::uint64_t evicted = 0;
  std::uint64_t compacted = 0;
  std::uint64_t cancelled = 0;
  for (const double share : {0.0, 0.001, 0.1, 0.3, 0.4, 0.6, 0.8, 1.0, 1.5, 3.0, 10.0}) {
    MemorySource source(world().files);
    HeapPageSink sink;
    const StreamerOptions options = options_for(cap_for(share));
    auto streamer = Streamer::open(source, options, sink);
    ASSERT_TRUE(streamer.ok()) << streamer.error().describe();
    SelectionTrace trace(1 << 20U);
    (*streamer)->observe(trace);
    ASSERT_TRUE(drive(**streamer, [&](int f) {
                  if (f % 10 == 0) check_cut(**streamer, sink);
                }).ok());
    // To and fro, faster than pages come.
    for (int f = 0; f < 40; ++f) {
      const View view = view_at(f % 2 == 0 ? 0.1 : 0.6);
      ASSERT_TRUE((*streamer)->advance(std::span(&view, 1), (kFrames + f) / 30.0).ok());
      check_cut(**streamer, sink);
    }
    const StreamerStatistics s = (*streamer)->statistics();
    EXPECT_EQ(s.frames, static_cast<std::uint64_t>(kFrames + 40));
    EXPECT_EQ(s.requests.issued, s.requests.completed + s.requests.cancelled + s.requests.failed + s.frame.in_flight);
    EXPECT_LE(s.max_in_flight, 6U);
    EXPECT_GE(sink.words().size() * 4, s.pool_bytes);
    if (share == 0.0) {
      EXPECT_EQ(s.zones_loaded, 1U);
    }
    if (share == 10.0) {
      EXPECT_EQ(s.reloads, 0U);
    }
    evicted += s.zones_evicted;
    compacted += s.compactions;
    cancelled += s.requests.cancelled;
    const std::optional<OptimalPaging> optimal = optimal_paging(trace, world().index, s.pool_bytes);
    ASSERT_TRUE(optimal);
    EXPECT_LE(optimal->reloads, s.reloads);
    EXPECT_LE(optimal->bytes_read, s.bytes_read);
    if (std::getenv("ZONECAST_PRINT") != nullptr)
      std::printf(
          "share %6.3f pool %7llu loaded %4llu evicted %4llu reloads %3llu optimal %3lld compactions %3llu "
          "cancelled %3llu wanted %3llu p50 %.0f p99 %.0f in flight %u\n",
          share, static_cast<unsigned long long>(s.pool_bytes), static_cast<unsigned long long>(s.zones_loaded),
          static_cast<unsigned long long>(s.zones_evicted), static_cast<unsigned long long>(s.reloads),
          static_cast<long long>(optimal->reloads), static_cast<unsigned long long>(s.compactions),
          static_cast<unsigned long long>(s.requests.cancelled), static_cast<unsigned long long>(s.wanted_level_frames),
          s.request_to_resident_ms.p50_ms, s.request_to_resident_ms.p99_ms, s.max_in_flight);
  }
  EXPECT_GT(evicted, 0U);
  EXPECT_GT(compacted, 0U);
  EXPECT_GT(cancelled, 0U);
}

TEST(Streamer, below_the_smallest_cap_fails_with_the_number_and_opens_exactly_at_it) {
  const std::uint64_t smallest = smallest_cap_bytes(world().index);
  for (const std::uint64_t cap : {std::uint64_t{0}, smallest - 1}) {
    MemorySource source(world().files);
    HeapPageSink sink;
    auto streamer = Streamer::open(source, options_for(cap), sink);
    ASSERT_FALSE(streamer.ok());
    EXPECT_EQ(streamer.error().code, ErrorCode::kBudget);
    EXPECT_NE(streamer.error().message.find(std::to_string(smallest)), std::string::npos);
  }
  MemorySource source(world().files);
  HeapPageSink sink;
  EXPECT_TRUE(Streamer::open(source, options_for(smallest), sink).ok());
}

TEST(Streamer, without_latency_every_wanted_node_is_there_in_the_same_frame) {
  MemorySource source(world().files);
  HeapPageSink sink;
  StreamerOptions options = options_for(64 << 20U);
  options.source_latency_s = 0;
  options.source_bandwidth_bytes_per_s = 0;
  auto streamer = Streamer::open(source, options, sink);
  ASSERT_TRUE(streamer.ok());
  SelectionTrace trace(1 << 20U);
  (*streamer)->observe(trace);
  ASSERT_TRUE(drive(**streamer).ok());
  const StreamerStatistics s = (*streamer)->statistics();
  EXPECT_EQ(s.wanted_level_frames, s.frames);
  EXPECT_EQ(s.request_to_resident_ms.max_ms, 0.0);
  const std::optional<OptimalPaging> optimal = optimal_paging(trace, world().index, s.pool_bytes);
  ASSERT_TRUE(optimal);
  EXPECT_EQ(optimal->reloads, 0U);
  EXPECT_EQ(optimal->bytes_read, s.bytes_read);
}

TEST(Streamer, latency_and_bandwidth_are_those_of_the_model) {
  MemorySource source(world().files);
  HeapPageSink sink;
  StreamerOptions options = options_for(64 << 20U);
  options.source_latency_s = 0.1;
  options.source_bandwidth_bytes_per_s = 0;
  auto streamer = Streamer::open(source, options, sink);
  ASSERT_TRUE(streamer.ok());
  const View view = view_at(0);
  ASSERT_TRUE((*streamer)->advance(std::span(&view, 1), 0.0).ok());
  EXPECT_EQ((*streamer)->rendered_cut().size(), 1U);
  ASSERT_TRUE((*streamer)->advance(std::span(&view, 1), 0.099).ok());
  EXPECT_EQ((*streamer)->rendered_cut().size(), 1U);
  ASSERT_TRUE((*streamer)->advance(std::span(&view, 1), 0.1).ok());
  EXPECT_GT((*streamer)->rendered_cut().size(), 1U);
  EXPECT_NEAR((*streamer)->statistics().request_to_resident_ms.p50_ms, 100, 1e-3);
}

TEST(Streamer, at_a_fixed_camera_settles_and_then_does_nothing) {
  for (const double share : {0.3, 0.5, 0.6, 0.7, 0.8, 1.0}) {
    MemorySource source(world().files);
    HeapPageSink sink;
    auto streamer = Streamer::open(source, options_for(cap_for(share)), sink);
    ASSERT_TRUE(streamer.ok());
    ASSERT_TRUE(drive(**streamer).ok());
    const View view = view_at(0.3);
    for (int f = 0; f < 200; ++f) ASSERT_TRUE((*streamer)->advance(std::span(&view, 1), 8 + f / 30.0).ok());
    const std::string log = (*streamer)->statistics().event_log_xxh3;
    const std::uint64_t generation = (*streamer)->rendered_cut_generation();
    for (int f = 200; f < 400; ++f) ASSERT_TRUE((*streamer)->advance(std::span(&view, 1), 8 + f / 30.0).ok());
    EXPECT_EQ((*streamer)->statistics().event_log_xxh3, log) << share;
    EXPECT_EQ((*streamer)->rendered_cut_generation(), generation) << share;
  }
}

// The pages that finer ones cover give way first: what a view asks for is there in a pool that could not hold the
// pages above it as well.
TEST(Streamer, under_pressure_the_pool_holds_what_is_shown) {
  bool found = false;
  for (const double share : {0.21, 0.22, 0.23, 0.24, 0.25, 0.26}) {
    MemorySource source(world().files);
    HeapPageSink sink;
    auto streamer = Streamer::open(source, options_for(cap_for(share)), sink);
    ASSERT_TRUE(streamer.ok());
    const View view = view_at(0.3);
    for (int f = 0; f < 200; ++f) ASSERT_TRUE((*streamer)->advance(std::span(&view, 1), f / 30.0).ok());
    check_cut(**streamer, sink);
    const StreamerStatistics s = (*streamer)->statistics();
    std::uint64_t above = 0;  // what is missing above the pages shown
    for (std::uint32_t n = 0; n < world().index.nodes.size(); ++n) {
      const NodeRecord& node = world().index.nodes[n];
      for (std::uint32_t c = node.first_child; c < node.first_child + node.child_count; ++c)
        if ((*streamer)->resident(c) && !(*streamer)->resident(n)) {
          above += pool_bytes(node);
          break;
        }
    }
    if (s.frame.missing_nodes == 0 && above > 0 && s.frame.resident_page_bytes + above > s.pool_bytes) found = true;
  }
  EXPECT_TRUE(found);
}

TEST(Streamer, a_damaged_or_vanished_page_is_covered_by_its_ancestor_and_retried) {
  for (const bool vanished : {false, true}) {
    MemorySource source(world().files);
    const std::uint32_t broken = 6;
    const std::string name = node_file(world().index.nodes[broken], vanished ? "zbvh" : "glb");
    if (vanished)
      source.remove(name);
    else
      source.flip_byte(name, 200);
    HeapPageSink sink;
    StreamerOptions options = options_for(64 << 20U);
    options.tolerance = 1e-6;
    std::vector<Error> errors;
    options.on_failure = [&](const Error& error) { errors.push_back(error); };
    auto streamer = Streamer::open(source, options, sink);
    ASSERT_TRUE(streamer.ok());
    ASSERT_TRUE(drive(**streamer, [&](int f) {
                  ASSERT_FALSE((*streamer)->resident(broken));
                  if (f % 40 == 0) check_cut(**streamer, sink);
                }).ok());
    StreamerStatistics s = (*streamer)->statistics();
    EXPECT_GE(s.requests.failed, 3U);
    EXPECT_EQ(s.requests.retried + 1, s.requests.failed);
    EXPECT_EQ(s.failed_nodes, 1U);
    ASSERT_EQ(errors.size(), 1U);
    EXPECT_EQ(errors[0].path, name);
    EXPECT_EQ(s.frame.resident_nodes, world().index.nodes.size() - 1);

    source.restore(name, world().files.at(name));
    const View view = view_at(0);
    for (int f = 0; f < 40; ++f) ASSERT_TRUE((*streamer)->advance(std::span(&view, 1), 20.0 + f).ok());
    EXPECT_TRUE((*streamer)->resident(broken));
  }
}

TEST(Streamer, a_broken_root_or_index_fails_at_open) {
  for (const std::string& name : {std::string(kWorldIndexName), node_file(world().index.nodes[0], "glb"),
                                  node_file(world().index.nodes[0], "zbvh")}) {
    MemorySource damaged(world().files);
    damaged.flip_byte(name, 100);
    HeapPageSink sink;
    auto first = Streamer::open(damaged, options_for(64 << 20U), sink);
    ASSERT_FALSE(first.ok());
    EXPECT_EQ(first.error().path, name);
    MemorySource missing(world().files);
    missing.remove(name);
    EXPECT_FALSE(Streamer::open(missing, options_for(64 << 20U), sink).ok());
  }
}

TEST(Streamer, on_a_wall_clock_settling_waits_for_every_selected_node) {
  MemorySource source(world().files);
  HeapPageSink sink;
  StreamerOptions options = options_for(64 << 20U);
  options.clock = ClockKind::kWall;
  options.settle = true;
  auto streamer = Streamer::open(source, options, sink);
  ASSERT_TRUE(streamer.ok());
  ASSERT_TRUE(drive(**streamer, [&](int f) {
                if (f % 40 == 0) check_cut(**streamer, sink);
              }).ok());
  const StreamerStatistics s = (*streamer)->statistics();
  EXPECT_EQ(s.wanted_level_frames, s.frames);
  EXPECT_EQ(s.frame.in_flight, 0U);
}

// As slow as a disk: loads are under way when the camera has gone on.
class SlowSource final : public Source {
 public:
  explicit SlowSource(test::Files files) : files_(std::move(files)) {}
  Result<std::vector<std::byte>> read(const std::string& name, std::uint64_t bytes) override {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    return files_.read(name, bytes);
  }
  Result<std::vector<std::byte>> read_all(const std::string& name, std::uint64_t limit_bytes) override {
    return files_.read_all(name, limit_bytes);
  }

 private:
  MemorySource files_;
};

TEST(Streamer, on_a_wall_clock_covers_the_world_while_it_cancels) {
  SlowSource source(world().files);
  HeapPageSink sink;
  StreamerOptions options = options_for(cap_for(0.8));
  options.clock = ClockKind::kWall;
  auto streamer = Streamer::open(source, options, sink);
  ASSERT_TRUE(streamer.ok());
  for (int round = 0; round < 5; ++round)
    ASSERT_TRUE(drive(**streamer, [&](int f) {
                  if (f % 40 == 0) check_cut(**streamer, sink);
                  std::this_thread::sleep_for(std::chrono::microseconds(500));
                }).ok());
  EXPECT_GT((*streamer)->statistics().requests.cancelled, 0U);
}

TEST(Streamer, pages_from_a_directory_and_detail_on_demand) {
  const TinyWorld small = test::make_tiny_world({.levels = 2, .detail = true});
  const std::filesystem::path dir = std::filesystem::path(testing::TempDir()) / "zonecast_streamer_test";
  std::filesystem::remove_all(dir);
  test::write_tiny_world(small, dir);
  auto source = open_directory_source(dir);
  ASSERT_TRUE(source.ok());
  EXPECT_FALSE((*source)->read_all("../x", 10).ok());
  EXPECT_FALSE((*source)->read(kWorldIndexName, 5).ok());
  for (const bool detail : {false, true}) {
    HeapPageSink sink;
    StreamerOptions options = options_for(64 << 20U);
    options.tolerance = 1e-6;
    options.include_detail = detail;
    options.source_latency_s = 0;
    options.source_bandwidth_bytes_per_s = 0;
    auto streamer = Streamer::open(**source, options, sink);
    ASSERT_TRUE(streamer.ok()) << streamer.error().describe();
    const View view{{1010, 1010, 2}};
    ASSERT_TRUE((*streamer)->advance(std::span(&view, 1), 0).ok());
    EXPECT_EQ((*streamer)->rendered_cut().size(), 4U);
    for (const std::uint32_t n : (*streamer)->rendered_cut())
      EXPECT_EQ((*streamer)->index().nodes[n].is_detail(), detail);
  }
  std::filesystem::remove_all(dir);
  EXPECT_FALSE(open_directory_source(dir).ok());
}

}  // namespace
}  // namespace zc
