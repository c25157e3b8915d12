// SPDX-License-Identifier: Apache-2.0
// The cap and the ledger against the executable's own operator new: what was really taken, never what the ledger says
// of itself. Sources that fail in every way, stops at any moment, and loads without end: ZONECAST_LOADS sets how many
// (1000000: some minutes).
#include <gtest/gtest.h>
#include <xxhash.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <random>
#include <thread>

#include "streamer/paging/heap_page_sink.h"
#include "streamer/paging/memory_plan.h"
#include "streamer/streamer.h"
#include "tests/unit/counted_memory.h"
#include "tests/unit/streamer/tiny_world.h"

namespace zc {
namespace {

using test::MemorySource;
using test::TinyWorld;

constexpr test::TinyWorldOptions kShape = {.levels = 4, .grid = 8, .soup = 10};

const TinyWorld& world() {
  static const TinyWorld kWorld = test::make_tiny_world(kShape);
  return kWorld;
}

std::uint64_t all_pages() {
  std::uint64_t bytes = 0;
  for (const NodeRecord& node : world().index.nodes) bytes += pool_bytes(node);
  return bytes;
}

long long largest_file_bytes() {
  std::size_t most = 0;
  for (const auto& [name, bytes] : world().files) most = std::max(most, bytes.size());
  return static_cast<long long>(most);
}

StreamerOptions options_for(double share) {
  StreamerOptions options;
  options.cap_bytes =
      smallest_cap_bytes(world().index) + static_cast<std::uint64_t>(share * static_cast<double>(all_pages()));
  options.tolerance = 0.004;
  options.max_in_flight = 6;
  return options;
}

View view_at(double t) {
  const double size = test::tiny_world_size_m(kShape);
  return {{test::kTinyOrigin_m + size * (0.5 + 0.45 * std::cos(t)),
           test::kTinyOrigin_m + size * (0.5 + 0.45 * std::sin(2 * t)), 2.0}};
}

std::size_t thread_count() {
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/task")) count += entry.exists() ? 1 : 0;
  return count;
}

// Without the world's own bytes, whoever asks first.
long long held() {
  world();
#ifdef __SANITIZE_ADDRESS__
  return 0;
#else
  return test::held_bytes;
#endif
}

// Cut, flipped, stalled and missing files, a share of all reads each; the root's and the index's are always whole.
class FaultySource final : public Source {
 public:
  explicit FaultySource(std::uint32_t seed) : files_(world().files), random_(seed) {}

  Result<std::vector<std::byte>> read(const std::string& name, std::uint64_t bytes) override {
    ZC_ASSIGN(std::vector<std::byte> data, files_.read(name, bytes));
    if (!faults_ || name.starts_with("zones/0/")) return data;
    switch (roll()) {
      case 0:
        data.resize(data.size() / 2);
        break;
      case 1:
        data[data.size() / 3] ^= std::byte{1};
        break;
      case 2:
        return Error{ErrorCode::kIo, "no such file", name};
      case 3:
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        return Error{ErrorCode::kIo, "timed out", name};
      case 4: {
        std::vector<std::byte> longer(data.size() + 7);
        std::ranges::copy(data, longer.begin());
        return longer;
      }
      default:
        break;
    }
    return data;
  }
  Result<std::vector<std::byte>> read_all(const std::string& name, std::uint64_t limit_bytes) override {
    return files_.read_all(name, limit_bytes);
  }
  void recover() { faults_ = false; }

 private:
  std::uint32_t roll() {
    const std::lock_guard lock(mutex_);
    return static_cast<std::uint32_t>(random_() % 12);
  }

  MemorySource files_;
  std::atomic<bool> faults_ = true;
  std::mutex mutex_;
  std::mt19937 random_;
};

struct Drive {
  long long most_bytes = 0;  // taken at a time, of the allocator
  StreamerStatistics statistics;
};

// Round through the world; then to and fro, faster than pages come.
Drive drive(Source& source, const StreamerOptions& options) {
  Drive out;
  out.most_bytes = test::most_memory_of([&] {
    HeapPageSink sink;
    auto streamer = Streamer::open(source, options, sink);
    ASSERT_TRUE(streamer.ok());
    for (int f = 0; f < 400; ++f) {
      const View view = view_at(f < 300 ? f / 40.0 : f % 2 == 0 ? 0.6 : 3.8);
      ASSERT_TRUE((*streamer)->advance(std::span(&view, 1), f / 30.0).ok());
    }
    out.statistics = (*streamer)->statistics();
  });
  return out;
}

// No tolerance: every byte of operator new counts, with the allocator's rounding.
TEST(PagingMemory, is_within_the_cap_and_never_more_than_the_ledger_says) {
  if (!test::kCountsMemory) GTEST_SKIP() << "AddressSanitizer's operator new counts nothing";
  std::uint64_t evicted = 0;
  std::uint64_t cancelled = 0;
  std::uint64_t compacted = 0;
  for (const double share : {0.0, 0.1, 0.2, 0.4, 0.6, 1.0, 1.5, 10.0})
    for (const double latency_s : {0.0, 0.05})
      for (const ClockKind clock : {ClockKind::kVirtual, ClockKind::kWall}) {
        if (clock == ClockKind::kWall && latency_s > 0) continue;  // a wall clock models no source
        MemorySource source(world().files);
        StreamerOptions options = options_for(share);
        options.clock = clock;
        options.source_latency_s = latency_s;
        options.source_bandwidth_bytes_per_s = latency_s > 0 ? 2e5 : 0;
        const Drive driven = drive(source, options);
        const auto peak = static_cast<long long>(driven.statistics.ledger.peak_bytes);
        SCOPED_TRACE(testing::Message() << "share " << share << ", latency " << latency_s << ", clock "
                                        << static_cast<int>(clock) << ": took " << driven.most_bytes << " of "
                                        << options.cap_bytes << ", ledger " << peak);
        EXPECT_LE(driven.most_bytes, static_cast<long long>(options.cap_bytes));
        EXPECT_LE(driven.most_bytes, peak);
        EXPECT_GE(3 * driven.most_bytes, peak);  // nor is the ledger all air
        if (share >= 0.2 && clock == ClockKind::kVirtual) {
          EXPECT_GT(driven.statistics.zones_loaded, 3U);
        }
        evicted += driven.statistics.zones_evicted;
        cancelled += driven.statistics.requests.cancelled;
        compacted += driven.statistics.compactions;
      }
  EXPECT_GT(evicted, 100U);
  EXPECT_GT(cancelled, 100U);
  EXPECT_GT(compacted, 10U);
}

// Answers so late that all workers have a file's bytes at once.
class LateSource final : public Source {
 public:
  explicit LateSource(const test::Files& files) : files_(files) {}
  Result<std::vector<std::byte>> read(const std::string& name, std::uint64_t bytes) override {
    auto data = files_.read(name, bytes);
    std::this_thread::sleep_for(std::chrono::milliseconds(3));
    return data;
  }
  Result<std::vector<std::byte>> read_all(const std::string& name, std::uint64_t limit_bytes) override {
    return files_.read_all(name, limit_bytes);
  }

 private:
  MemorySource files_;
};

// The world with so much more in the binary chunk of each `.glb`, which no mesh refers to.
TinyWorld with_longer_files(TinyWorld world, std::uint32_t more_bytes) {
  for (NodeRecord& node : world.index.nodes) {
    std::vector<std::byte>& glb = world.files[node_file(node, "glb")];
    const auto lengthen = [&](std::size_t at) {
      std::uint32_t length = 0;
      std::memcpy(&length, glb.data() + at, sizeof length);
      length += more_bytes;
      std::memcpy(glb.data() + at, &length, sizeof length);
    };
    std::uint32_t json_bytes = 0;
    std::memcpy(&json_bytes, glb.data() + 12, sizeof json_bytes);
    lengthen(8);
    lengthen(20 + json_bytes);
    glb.resize(glb.size() + more_bytes);
    node.glb_bytes = glb.size();
    node.glb_xxh3 = XXH3_64bits(glb.data(), glb.size());
  }
  world.files[kWorldIndexName] = encode_world_index(world.index);
  return world;
}

// Files that are far larger than what comes out of them, then meshes that take far more to decode than they leave: each
// class of the ledger is for once the largest, and what it stands for must be no more.
TEST(PagingMemory, of_compressed_bytes_and_of_decoding_is_reserved_before_it_is_taken) {
  if (!test::kCountsMemory) GTEST_SKIP() << "AddressSanitizer's operator new counts nothing";
  const TinyWorld long_files = with_longer_files(test::make_tiny_world({.levels = 3}), 200'000);
  const TinyWorld large_zones = test::make_tiny_world({.levels = 2, .grid = 60, .soup = 300});
  for (const TinyWorld* world : {&long_files, &large_zones}) {
    LateSource source(world->files);
    StreamerOptions options;
    options.cap_bytes = 64 << 20U;
    options.tolerance = 1e-6;
    options.threads = world == &long_files ? 6 : 1;
    options.max_in_flight = options.threads;
    std::uint64_t peak = 0;
    const long long most = test::most_memory_of([&] {
      HeapPageSink sink;
      auto streamer = Streamer::open(source, options, sink);
      ASSERT_TRUE(streamer.ok()) << streamer.error().describe();
      for (int f = 0; f < 40; ++f) {
        const View view{{test::kTinyOrigin_m + 10, test::kTinyOrigin_m + 10, 2.0}};
        ASSERT_TRUE((*streamer)->advance(std::span(&view, 1), f / 30.0).ok());
      }
      EXPECT_EQ((*streamer)->statistics().frame.resident_nodes, world->index.nodes.size());
      peak = (*streamer)->statistics().ledger.peak_bytes;
    });
    EXPECT_LE(most, static_cast<long long>(peak));
    EXPECT_GE(3 * most, static_cast<long long>(peak));
  }
}

TEST(PagingFaults, cost_detail_and_nothing_else_and_heal) {
  for (std::uint32_t seed = 0; seed < 6; ++seed) {
    for (const ClockKind clock : {ClockKind::kVirtual, ClockKind::kWall}) {
      FaultySource source(seed);
      const long long with_source = held();
      const long long most = test::most_memory_of([&] {
        HeapPageSink sink;
        StreamerOptions options = options_for(seed % 2 == 0 ? 0.6 : 4.0);
        options.clock = clock;
        options.settle = clock == ClockKind::kWall;
        auto streamer = Streamer::open(source, options, sink);
        ASSERT_TRUE(streamer.ok());
        const auto drive = [&](double from_s) {
          for (int f = 0; f < 200; ++f) {
            const View view = view_at(f / 30.0);
            ASSERT_TRUE((*streamer)->advance(std::span(&view, 1), from_s + f / 30.0).ok());
            const StreamerStatistics s = (*streamer)->statistics();
            ASSERT_GE(s.frame.cover_nodes, 1U);
            ASSERT_EQ(s.requests.issued,
                      s.requests.completed + s.requests.cancelled + s.requests.failed + s.frame.in_flight);
          }
        };
        drive(0);
        const StreamerStatistics sick = (*streamer)->statistics();
        EXPECT_GT(sick.requests.failed, 3U);
        EXPECT_GT(sick.requests.retried, 0U);
        source.recover();
        drive(100);
        const StreamerStatistics well = (*streamer)->statistics();
        EXPECT_EQ(well.requests.failed, sick.requests.failed);
        if (seed % 2 == 1) {
          EXPECT_EQ(well.frame.missing_nodes, 0U);
        }
      });
      // A file that comes longer than asked for is in memory twice, in the source, for each that reads.
      const long long twice = static_cast<long long>(options_for(1).max_in_flight) * largest_file_bytes();
      EXPECT_LE(most, static_cast<long long>(options_for(seed % 2 == 0 ? 0.6 : 4.0).cap_bytes) + twice) << seed;
      EXPECT_LE(std::abs(held() - with_source), 4096) << "bytes that did not come back, seed " << seed;
    }
  }
}

TEST(PagingStop, at_any_moment_joins_every_thread_and_returns_every_byte) {
  std::thread([] {}).join();  // ThreadSanitizer starts a thread of its own with the first one
  const std::size_t threads = thread_count();
  const long long before = held();
  std::mt19937 random(9);
  for (int i = 0; i < 60; ++i) {
    FaultySource source(static_cast<std::uint32_t>(i));
    HeapPageSink sink;
    StreamerOptions options = options_for(0.8);
    options.threads = 1 + static_cast<unsigned>(i % 8);
    options.clock = i % 2 == 0 ? ClockKind::kVirtual : ClockKind::kWall;
    options.source_latency_s = i % 2 == 0 ? 0.1 : 0;
    auto streamer = Streamer::open(source, options, sink);
    ASSERT_TRUE(streamer.ok());
    for (std::uint32_t f = 0; f < random() % 12; ++f) {
      const View view = view_at(static_cast<double>(random() % 700) / 100);
      ASSERT_TRUE((*streamer)->advance(std::span(&view, 1), f / 30.0).ok());
    }
  }
  // The kernel wakes who joins a thread a moment before it takes the thread off its list.
  for (int i = 0; i < 200 && thread_count() != threads; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_EQ(thread_count(), threads);
  EXPECT_LE(std::abs(held() - before), 4096);
}

TEST(PagingMemory, does_not_grow_with_loads_nor_with_cancelled_ones) {
  const char* asked = std::getenv("ZONECAST_LOADS");
  const std::uint64_t loads = asked != nullptr ? std::strtoull(asked, nullptr, 10) : 5000;
  MemorySource source(world().files);
  HeapPageSink sink;
  StreamerOptions options = options_for(0.3);
  options.source_latency_s = 0.05;
  const long long before = held();
  auto streamer = Streamer::open(source, options, sink);
  ASSERT_TRUE(streamer.ok());
  long long early = 0;
  for (int f = 0; (*streamer)->statistics().zones_loaded < loads; ++f) {
    ASSERT_LT(f, 20'000'000);
    const View view = view_at(f / 3);  // far from where it was, while something is on its way
    ASSERT_TRUE((*streamer)->advance(std::span(&view, 1), f / 30.0).ok());
    if (early == 0 && (*streamer)->statistics().zones_loaded > loads / 10) early = held();
  }
  EXPECT_GT((*streamer)->statistics().requests.cancelled, loads / 20);
  EXPECT_LE(held() - early, 16384);
  EXPECT_LE(held() - before, static_cast<long long>(options.cap_bytes));
}

}  // namespace
}  // namespace zc
