// SPDX-License-Identifier: Apache-2.0
// The plan of a cap with what the sink takes: all of it is in the plan, and no buffer is larger than the sink binds.
#include "streamer/paging/memory_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include "streamer/paging/heap_page_sink.h"
#include "streamer/paging/pager_state.h"
#include "streamer/streamer.h"
#include "tests/unit/streamer/tiny_world.h"

namespace zc {
namespace {

const test::TinyWorld& world() {
  static const test::TinyWorld kWorld = test::make_tiny_world({.levels = 4, .grid = 8, .soup = 10});
  return kWorld;
}

std::uint64_t all_pages() {
  std::uint64_t bytes = 0;
  for (const NodeRecord& node : world().index.nodes) bytes += pool_bytes(node);
  return bytes;
}

std::uint64_t buffer_bytes(const MemoryPlan& plan, const SinkCosts& sink) {
  return plan.pool_bytes + sink.buffer_fixed_bytes + plan.pages * sink.buffer_bytes_per_page;
}

TEST(MemoryPlan, HasAllThatTheSinkTakesAndNoMoreThanTheCap) {
  for (const std::uint64_t fixed : {0U, 1000U, 300'000U}) {
    for (const std::uint64_t per_page : {0U, 128U, 1500U, 40'000U}) {
      const SinkCosts sink{.fixed_bytes = fixed, .bytes_per_page = per_page};
      const std::uint64_t smallest = smallest_cap_bytes(world().index, {}, sink);
      EXPECT_EQ(smallest, smallest_cap_bytes(world().index) + fixed + per_page);
      ASSERT_FALSE(plan_memory(world().index, {.cap_bytes = smallest - 1}, {}, sink).ok());
      for (const std::uint64_t more : {std::uint64_t{0}, all_pages() / 5, all_pages(), 40 * all_pages()}) {
        const auto plan = plan_memory(world().index, {.cap_bytes = smallest + more}, {}, sink);
        ASSERT_TRUE(plan.ok()) << plan.error().describe();
        EXPECT_EQ(plan->top_level_bytes, fixed + plan->pages * per_page);
        EXPECT_EQ(plan->index_bytes + plan->state_bytes + plan->top_level_bytes + plan->pool_bytes +
                      plan->scratch_bytes + plan->in_flight_bytes,
                  smallest + more);
        EXPECT_FALSE(plan->pool_limited_by_sink);
        EXPECT_LE(plan->pages, world().index.nodes.size());
        if (more == 40 * all_pages() && per_page < 40'000) {
          EXPECT_EQ(plan->pool_bytes, all_pages());
          EXPECT_EQ(plan->pages, world().index.nodes.size());
        }
      }
    }
  }
}

TEST(MemoryPlan, BindsNoLargerBufferThanTheSinkCanAndSaysSo) {
  SinkCosts sink{.fixed_bytes = 5000, .bytes_per_page = 2000, .buffer_fixed_bytes = 1360, .buffer_bytes_per_page = 240};
  const StreamerOptions options{.cap_bytes = 40 * all_pages() + smallest_cap_bytes(world().index, {}, sink)};
  const std::uint64_t root = pool_bytes(world().index.nodes[0]);
  const std::uint64_t least = root + 1360 + 240;
  const std::uint64_t whole = all_pages() + 1360 + 240 * world().index.nodes.size();
  std::uint64_t before = 0;
  for (std::uint64_t limit = least; limit < whole + 4096; limit += 777) {
    sink.buffer_limit_bytes = limit;
    const auto plan = plan_memory(world().index, options, {}, sink);
    ASSERT_TRUE(plan.ok()) << plan.error().describe();
    ASSERT_LE(buffer_bytes(*plan, sink), limit);
    EXPECT_EQ(plan->pool_limited_by_sink, limit < whole) << limit << " of " << whole;
    EXPECT_GE(plan->pool_bytes, before);
    before = plan->pool_bytes;
  }
  EXPECT_EQ(before, all_pages());
  sink.buffer_limit_bytes = least - 1;
  const auto plan = plan_memory(world().index, options, {}, sink);
  ASSERT_FALSE(plan.ok());
  EXPECT_NE(plan.error().message.find(std::to_string(least)), std::string::npos);
}

// What the sink is told of the rendered cut, held against the streamer and the index.
class CheckedSink final : public PageSink {
 public:
  explicit CheckedSink(const SinkCosts& costs) : costs_(costs) {}
  [[nodiscard]] SinkCosts costs() const override { return costs_; }
  Status create(std::uint64_t capacity_words, std::uint64_t max_pages) override {
    capacity_words_ = capacity_words;
    max_pages_ = max_pages;
    return {};
  }
  Status upload(std::uint64_t offset_words, std::span<const std::uint32_t> page) override {
    place(offset_words, page.size());
    return {};
  }
  Status move(std::uint64_t from_words, std::uint64_t to_words, std::uint64_t count_words) override {
    EXPECT_EQ(pages_.at(from_words), count_words);
    pages_.erase(from_words);
    place(to_words, count_words);
    return {};
  }
  void remove(std::uint64_t offset_words) override { EXPECT_EQ(pages_.erase(offset_words), 1U); }
  Status show(std::span<const ShownPage> pages) override {
    EXPECT_FALSE(shows_ > 0 && std::ranges::equal(pages, shown)) << "nothing changed";
    shown.assign(pages.begin(), pages.end());
    for (std::size_t i = 0; i < shown.size(); ++i) {
      EXPECT_TRUE(pages_.contains(shown[i].offset_words));
      EXPECT_TRUE(i == 0 || shown[i - 1].offset_words < shown[i].offset_words);
      coarse += shown[i].coarse ? 1 : 0;
    }
    ++shows_;
    return {};
  }

  std::vector<ShownPage> shown;
  std::size_t coarse = 0;

 private:
  void place(std::uint64_t offset_words, std::uint64_t words) {
    EXPECT_LE(offset_words + words, capacity_words_);
    const auto next = pages_.lower_bound(offset_words);
    EXPECT_TRUE(next == pages_.end() || offset_words + words <= next->first);
    EXPECT_TRUE(next == pages_.begin() || std::prev(next)->first + std::prev(next)->second <= offset_words);
    pages_[offset_words] = words;
    EXPECT_LE(pages_.size(), max_pages_);
  }

  SinkCosts costs_;
  std::uint64_t capacity_words_ = 0;
  std::uint64_t max_pages_ = 0;
  std::map<std::uint64_t, std::uint64_t> pages_;
  int shows_ = 0;
};

TEST(PageSink, IsShownTheRenderedCutWheneverItChangesAndNeverHasMorePagesThanPlanned) {
  const SinkCosts costs{.fixed_bytes = 1000, .bytes_per_page = 1500};
  for (const double share : {0.2, 0.5, 2.0}) {
    test::MemorySource source(world().files);
    CheckedSink sink(costs);
    StreamerOptions options;
    options.cap_bytes = smallest_cap_bytes(world().index, {}, costs) +
                        static_cast<std::uint64_t>(share * static_cast<double>(all_pages()));
    options.tolerance = 0.01;
    auto streamer = Streamer::open(source, options, sink);
    ASSERT_TRUE(streamer.ok()) << streamer.error().describe();
    ASSERT_EQ(sink.shown.size(), 1U);
    for (int f = 0; f < 200; ++f) {
      const double size = test::tiny_world_size_m({.levels = 4});
      const View now{{test::kTinyOrigin_m + size * f / 200, test::kTinyOrigin_m + size / 2, 2}};
      const View later{{test::kTinyOrigin_m + size * (f + 20) / 200, test::kTinyOrigin_m + size / 2, 2}, 1};
      const std::array views = {now, later};
      ASSERT_TRUE((*streamer)->advance(views, f / 30.0).ok());
      std::vector<ShownPage> expected;
      for (const std::uint32_t n : (*streamer)->rendered_cut()) {
        const bool finest = world().index.nodes[n].child_count == 0;
        expected.push_back({(*streamer)->page_offset_words(n), n,
                            !finest && weighted_error(world().index, n, std::span(&now, 1)) > options.tolerance});
      }
      std::ranges::sort(expected, {}, &ShownPage::offset_words);
      ASSERT_TRUE(std::ranges::equal(sink.shown, expected)) << f;
    }
    EXPECT_EQ(sink.coarse > 0, share < 1) << share;
  }
}

}  // namespace
}  // namespace zc
