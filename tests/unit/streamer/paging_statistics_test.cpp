// SPDX-License-Identifier: Apache-2.0
// What is counted about paging, against cases worked by hand; and the page pool.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "streamer/paging/heap_page_sink.h"
#include "streamer/paging/look_ahead.h"
#include "streamer/paging/memory_plan.h"
#include "streamer/paging/page_loader.h"
#include "streamer/paging/page_pool.h"
#include "streamer/statistics/camera_cuts.h"
#include "streamer/statistics/latency_samples.h"
#include "streamer/streamer.h"
#include "tests/unit/streamer/tiny_world.h"

namespace zc {
namespace {

using test::MemorySource;
using test::TinyWorld;

const TinyWorld& world() {
  static const TinyWorld kWorld = test::make_tiny_world({.levels = 4, .grid = 8});
  return kWorld;
}

View at(double x, double y, std::uint32_t steps_ahead = 0) {
  return {{test::kTinyOrigin_m + x, test::kTinyOrigin_m + y, 2}, steps_ahead};
}

TEST(LatencySamples, percentiles_are_at_most_a_32nd_too_large_whatever_the_scale) {
  std::mt19937 random(3);
  for (const double scale_ms : {1e-3, 1.0, 300.0, 2e6}) {
    LatencySamples samples;
    std::vector<double> all;
    for (int i = 0; i < 5000; ++i) {
      all.push_back(scale_ms * (1 + static_cast<double>(random() % 1000)) / 1000);
      samples.add(all.back());
    }
    std::sort(all.begin(), all.end());
    const LatencySummary s = samples.summary();
    EXPECT_EQ(s.samples, 5000U);
    EXPECT_EQ(s.max_ms, all.back());
    for (const auto& [share, ms] : {std::pair(0.5, s.p50_ms), {0.95, s.p95_ms}, {0.99, s.p99_ms}}) {
      const double exact = all[static_cast<std::size_t>(std::ceil(share * 5000)) - 1];
      EXPECT_GE(ms, exact);
      EXPECT_LE(ms, exact * (1 + 1.0 / 31));
    }
  }
  EXPECT_EQ(LatencySamples().summary().p99_ms, 0.0);
}

TEST(CameraCuts, are_jumps_not_speed_and_last_until_everything_is_there) {
  CameraCuts camera_cuts;
  const auto frame = [&](std::vector<View> views, double time_s, bool there) {
    camera_cuts.begin_frame(views, time_s);
    camera_cuts.end_frame(there);
  };
  frame({at(0, 0), at(900, 0, 1), at(0, 500)}, 0, false);  // two cameras
  frame({at(90, 0), at(0, 500)}, 0.03, false);             // 3,000 m/s, but no 100 m
  frame({at(590, 0), at(0, 500)}, 5, false);               // 500 m, but in five seconds
  EXPECT_EQ(camera_cuts.statistics().count, 0U);
  frame({at(590, 0), at(300, 500)}, 5.1, false);  // the second jumps
  frame({at(590, 0), at(300, 500)}, 5.3, true);
  frame({at(590, 0), at(300, 500)}, 5.4, true);
  frame({at(0, 0), at(300, 500)}, 5.5, false);
  CameraCutStatistics s = camera_cuts.statistics();
  EXPECT_EQ(s.count, 2U);
  EXPECT_EQ(s.unfinished, 1U);
  EXPECT_EQ(s.to_target_ms.samples, 1U);
  EXPECT_NEAR(s.to_target_ms.max_ms, 200, 1e-6);
  frame({at(590, 0), at(300, 500)}, 5.6, true);  // before the last one was done; there at once
  s = camera_cuts.statistics();
  EXPECT_EQ(s.count, 3U);
  EXPECT_EQ(s.unfinished, 1U);
  EXPECT_NEAR(s.to_target_ms.p50_ms, 0, 1e-3);
}

TEST(LookAhead, a_live_camera_goes_on_as_it_goes) {
  std::vector<View> views;
  extrapolate_views({10, 20, 30}, {4, 0, -2}, 2, 4, views);
  ASSERT_EQ(views.size(), 5U);
  EXPECT_EQ(views[0].steps_ahead, 0U);
  EXPECT_EQ(views[4].steps_ahead, 4U);
  EXPECT_EQ(views[4].eye, glm::dvec3(18, 20, 26));
  EXPECT_EQ(views[1].eye, glm::dvec3(12, 20, 29));
  extrapolate_views({0, 0, 0}, {4, 0, -2}, 0, 4, views);
  EXPECT_EQ(views.size(), 6U);
}

// Pages that differ from node to node and survive every move.
TEST(PagePool, keeps_every_page_whole_through_evictions_and_moves_no_more_than_it_must) {
  const WorldIndex& index = world().index;
  std::vector<std::vector<std::uint32_t>> pages;
  std::uint64_t all_words = 0;
  for (std::uint32_t n = 0; n < index.nodes.size(); ++n) {
    pages.emplace_back(index.nodes[n].page_bytes / 4, n + 1);
    all_words += aligned_words(pages.back().size());
  }
  HeapPageSink sink;
  const std::uint64_t words = all_words / 3;
  ASSERT_TRUE(sink.create(words, index.nodes.size()).ok());
  PagePool pool(index, sink, words, index.nodes.size());
  ASSERT_TRUE(pool.add(0, pages[0]).ok());
  std::mt19937 random(5);
  for (int i = 0; i < 5000; ++i) {
    const auto n = static_cast<std::uint32_t>(1 + random() % (index.nodes.size() - 1));
    if (pool.nodes().resident(n)) continue;
    while (!pool.has_room_for(n)) {
      const auto residents = pool.residents();
      const std::uint32_t victim = residents[random() % residents.size()];
      if (victim != 0) pool.remove(victim);
    }
    const std::uint64_t moved = pool.compacted_bytes();
    ASSERT_TRUE(pool.add(n, pages[n]).ok());
    EXPECT_LE(pool.compacted_bytes() - moved, 4 * words);
    std::uint64_t bytes = 0;
    for (const std::uint32_t r : pool.residents()) {
      const auto held = sink.words().subspan(pool.offset_words(r), pages[r].size());
      ASSERT_TRUE(std::equal(pages[r].begin(), pages[r].end(), held.begin())) << r;
      bytes += 4 * pages[r].size();
    }
    EXPECT_EQ(bytes, pool.page_bytes());
  }
  EXPECT_GT(pool.compactions(), 100U);
  // Sliding everything would have moved about all of the pool each time.
  EXPECT_LT(pool.compacted_bytes() / pool.compactions(), 4 * words / 2);
}

StreamerOptions unlimited() { return {.cap_bytes = 64 << 20U, .tolerance = 0.02}; }

TEST(PagingStatistics, a_prefetched_page_is_pending_then_used) {
  MemorySource source(world().files);
  HeapPageSink sink;
  auto streamer = Streamer::open(source, unlimited(), sink);
  ASSERT_TRUE(streamer.ok());
  const double size = test::tiny_world_size_m({.levels = 4});
  const std::vector<View> views = {at(-4000, 0), at(size / 2, size / 2, 1)};
  ASSERT_TRUE((*streamer)->advance(views, 0).ok());
  StreamerStatistics s = (*streamer)->statistics();
  const std::uint64_t root = compressed_bytes(world().index.nodes[0]);
  EXPECT_GT(s.zones_loaded, 5U);
  EXPECT_EQ(s.prefetch.used, 0U);
  EXPECT_EQ(s.prefetch.wasted, 0U);
  EXPECT_EQ(s.prefetch.pending, s.bytes_read - root);
  ASSERT_TRUE((*streamer)->advance(std::span(&views[1], 1), 1).ok());  // a view ahead alone: nobody is there yet
  EXPECT_EQ((*streamer)->statistics().prefetch.used, 0U);
  const View there = at(size / 2, size / 2);
  ASSERT_TRUE((*streamer)->advance(std::span(&there, 1), 2).ok());
  s = (*streamer)->statistics();
  EXPECT_EQ(s.prefetch.used, s.bytes_read - root);
  EXPECT_EQ(s.prefetch.pending, 0U);
}

TEST(PagingStatistics, uploads_per_frame_keep_to_their_budget) {
  std::uint64_t largest = 0;
  for (const NodeRecord& node : world().index.nodes) largest = std::max<std::uint64_t>(largest, node.page_bytes);
  for (const std::uint64_t budget : {std::uint64_t{1}, 2 * largest}) {
    MemorySource source(world().files);
    HeapPageSink sink;
    StreamerOptions options = unlimited();
    options.upload_bytes_per_frame = budget;
    auto streamer = Streamer::open(source, options, sink);
    ASSERT_TRUE(streamer.ok());
    const View view = at(100, 100);
    std::uint64_t before = (*streamer)->statistics().frame.resident_page_bytes;
    std::uint32_t loads = 0;
    int frames = 0;
    do {
      ASSERT_TRUE((*streamer)->advance(std::span(&view, 1), frames++ / 30.0).ok());
      const FrameStatistics frame = (*streamer)->statistics().frame;
      if (frames > 1) {
        EXPECT_LE(frame.resident_page_bytes - before, std::max(budget, largest));
      }
      before = frame.resident_page_bytes;
      loads = frame.loads;
      if (budget == 1) {
        EXPECT_LE(loads, 1U);
      }
    } while (loads > 0);
    EXPECT_GT(frames, 5);
    EXPECT_EQ((*streamer)->statistics().frame.missing_nodes, 0U);
  }
}

TEST(PagingStatistics, thrash_is_a_reload_soon_after_the_eviction) {
  MemorySource source(world().files);
  HeapPageSink sink;
  StreamerOptions options = unlimited();
  std::uint64_t pages = 0;
  for (const NodeRecord& node : world().index.nodes) pages += pool_bytes(node);
  options.tolerance = 0.004;
  options.cap_bytes = smallest_cap_bytes(world().index) + pages / 4;
  auto streamer = Streamer::open(source, options, sink);
  ASSERT_TRUE(streamer.ok());
  const double size = test::tiny_world_size_m({.levels = 4});
  const std::vector<View> corners = {at(0, 0), at(size, size)};
  int frame = 0;
  const auto stay = [&](const View& view, int frames) {
    for (int i = 0; i < frames; ++i) ASSERT_TRUE((*streamer)->advance(std::span(&view, 1), ++frame / 30.0).ok());
  };
  for (int i = 0; i < 3; ++i)
    for (const View& corner : corners) stay(corner, 100);
  StreamerStatistics s = (*streamer)->statistics();
  ASSERT_GT(s.reloads, 0U) << "the cap is not tight";
  EXPECT_EQ(s.thrash, 0U);
  for (int i = 0; i < 3; ++i)
    for (const View& corner : corners) stay(corner, 5);
  const std::uint64_t soon = (*streamer)->statistics().reloads - s.reloads;
  EXPECT_GT((*streamer)->statistics().thrash, 0U);
  EXPECT_LE((*streamer)->statistics().thrash, soon);
  EXPECT_EQ((*streamer)->statistics().camera_cuts.count, 11U);
}

class Recorder final : public PagingObserver {
 public:
  void on_span(const PagingSpan& span) override { spans.push_back(span); }
  std::vector<PagingSpan> spans;
};

TEST(PagingObserver, sees_every_state_of_every_page_in_order) {
  MemorySource source(world().files);
  HeapPageSink sink;
  Recorder recorder;
  StreamerOptions options = unlimited();
  options.threads = 3;
  auto streamer = Streamer::open(source, options, sink);
  ASSERT_TRUE(streamer.ok());
  (*streamer)->observe(recorder);
  const View view = at(100, 100);
  ASSERT_TRUE((*streamer)->advance(std::span(&view, 1), 0).ok());
  const std::uint64_t pages = (*streamer)->statistics().zones_loaded - 1;
  ASSERT_GT(pages, 5U);
  EXPECT_EQ(recorder.spans.size(), 4 * pages);
  for (std::size_t i = 0; i < recorder.spans.size(); ++i) {
    const PagingSpan& span = recorder.spans[i];
    EXPECT_EQ(static_cast<std::size_t>(span.state), i % 4);
    EXPECT_LE(span.begin, span.end);
    EXPECT_LT(span.worker, 3U);
    if (i % 4 == 0) continue;
    EXPECT_EQ(span.node, recorder.spans[i - 1].node);
    EXPECT_GE(span.begin, recorder.spans[i - 1].end);
  }
  const StreamerStatistics s = (*streamer)->statistics();
  EXPECT_EQ(s.state_ms[static_cast<std::size_t>(LoadState::kDecoding)].samples, pages);
  EXPECT_EQ(s.state_ms[static_cast<std::size_t>(LoadState::kRetiring)].samples, 0U);
}

// Cameras, camera_cuts, reversals: one budget.
TEST(Cameras, share_one_budget_and_each_gets_what_it_asks_for) {
  const double size = test::tiny_world_size_m({.levels = 4});
  const auto wanted_of = [&](std::span<const View> views, std::uint64_t cap) {
    MemorySource source(world().files);
    HeapPageSink sink;
    StreamerOptions options = unlimited();
    options.cap_bytes = cap;
    auto streamer = Streamer::open(source, options, sink);
    EXPECT_TRUE(streamer.ok());
    EXPECT_TRUE((*streamer)->advance(views, 0).ok());
    EXPECT_EQ((*streamer)->statistics().frame.missing_nodes, 0U);
    EXPECT_LE((*streamer)->statistics().ledger.peak_bytes, cap);
    std::vector<std::uint32_t> there((*streamer)->rendered_cut().begin(), (*streamer)->rendered_cut().end());
    return there;
  };
  const std::vector<View> both = {at(30, 30), at(size - 30, size - 30)};
  const std::vector<std::uint32_t> first = wanted_of(std::span(both).first(1), 64 << 20U);
  const std::vector<std::uint32_t> second = wanted_of(std::span(both).last(1), 64 << 20U);
  const std::vector<std::uint32_t> together = wanted_of(both, 64 << 20U);
  // What is shown at leaf level for one of them is for both.
  for (const std::uint32_t n : together) {
    const auto shows = [&](const std::vector<std::uint32_t>& cut) { return std::ranges::count(cut, n) > 0; };
    EXPECT_TRUE(shows(first) || shows(second)) << n;
  }
  const auto leaves = [&](const std::vector<std::uint32_t>& cut) {
    return std::ranges::count_if(cut, [&](std::uint32_t n) { return world().index.nodes[n].child_count == 0; });
  };
  EXPECT_EQ(leaves(together), leaves(first) + leaves(second));
}

TEST(Cameras, camera_cuts_and_reversals_of_two_cameras_stay_under_the_cap_and_repeat_at_any_thread_count) {
  const double size = test::tiny_world_size_m({.levels = 4});
  std::uint64_t pages = 0;
  for (const NodeRecord& node : world().index.nodes) pages += pool_bytes(node);
  std::string log;
  for (const unsigned threads : {1U, 2U, 4U, 8U}) {
    MemorySource source(world().files);
    HeapPageSink sink;
    StreamerOptions options = unlimited();
    options.cap_bytes = smallest_cap_bytes(world().index) + pages;
    options.threads = threads;
    options.source_latency_s = 0.05;
    options.source_bandwidth_bytes_per_s = 2e4;
    options.tolerance = 0.004;
    auto streamer = Streamer::open(source, options, sink);
    ASSERT_TRUE(streamer.ok());
    std::mt19937 random(7);
    double along = 0;
    double step = 3;
    for (int f = 0; f < 600; ++f) {
      if (f % 50 == 49) step = -step;                                        // a reversal
      if (f % 120 == 119) along += along > size / 2 ? -size / 2 : size / 2;  // a camera cut
      along += step;
      const std::vector<View> views = {at(along, 200), at(along + 8 * step, 200, 1), at(200, size - along),
                                       at(200, size - along - 8 * step, 1)};
      ASSERT_TRUE((*streamer)->advance(views, f / 30.0).ok());
    }
    const StreamerStatistics s = (*streamer)->statistics();
    EXPECT_EQ(s.camera_cuts.count, 5U);
    EXPECT_GT(s.camera_cuts.to_target_ms.samples + s.camera_cuts.unfinished, 0U);
    EXPECT_GT(s.requests.cancelled, 0U);
    EXPECT_EQ(s.requests.issued, s.requests.completed + s.requests.cancelled + s.requests.failed + s.frame.in_flight);
    if (log.empty()) log = s.event_log_xxh3;
    EXPECT_EQ(s.event_log_xxh3, log) << threads;
  }
}

}  // namespace
}  // namespace zc
