// SPDX-License-Identifier: Apache-2.0
// The HTTP source against the server of `zonecast serve`, both in this process.
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <random>
#include <thread>

#include "replay/files/archive_writer.h"
#include "replay/serve/world_server.h"
#include "streamer/open_source.h"
#include "streamer/paging/heap_page_sink.h"
#include "streamer/paging/memory_plan.h"
#include "streamer/paging/page_loader.h"
#include "streamer/source/http/client.h"
#include "streamer/source/http/web_address.h"
#include "streamer/streamer.h"
#include "tests/unit/streamer/tiny_world.h"

namespace zc {
namespace {

namespace fs = std::filesystem;

constexpr test::TinyWorldOptions kShape = {.levels = 4, .grid = 8, .soup = 10};

const test::TinyWorld& world() {
  static const test::TinyWorld kWorld = test::make_tiny_world(kShape);
  return kWorld;
}

// Serves until it goes.
class Running {
 public:
  explicit Running(const fs::path& place, int port = 0) {
    auto served = ServedWorld::open(place);
    EXPECT_TRUE(served.ok());
    ServeOptions options;
    options.port = port;
    auto server = WorldServer::listen(std::move(served).value(), options);
    EXPECT_TRUE(server.ok()) << server.error().describe();
    server_ = std::move(server).value();
    thread_ = std::thread([this] { server_->run(); });
  }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;
  ~Running() {
    server_->stop();
    thread_.join();
  }
  [[nodiscard]] int port() const { return server_->port(); }
  [[nodiscard]] std::string url(const std::string& name = {}) const {
    return "http://127.0.0.1:" + std::to_string(port()) + "/" + name;
  }

 private:
  std::unique_ptr<WorldServer> server_;
  std::thread thread_;
};

class HttpSource : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(folder_);
    test::write_tiny_world(world(), folder_ / "world");
    auto archive = ArchiveWriter::create(folder_ / "a.3tz");
    ASSERT_TRUE(archive.ok());
    for (const auto& [name, bytes] : world().files) ASSERT_TRUE(archive->add(name, bytes).ok());
    ASSERT_TRUE(archive->commit().ok());
  }
  void TearDown() override { fs::remove_all(folder_); }

  static std::unique_ptr<Source> open(const std::string& url) {
    auto source = open_source(url, {.timeout_s = 5});
    EXPECT_TRUE(source.ok()) << source.error().describe();
    return std::move(source).value();
  }

  const fs::path folder_ = fs::temp_directory_path() / ("zonecast-http-test-" + std::to_string(::getpid()));
};

View view_at(double t) {
  const double size = test::tiny_world_size_m(kShape);
  return {{test::kTinyOrigin_m + size * (0.5 + 0.45 * std::cos(6.28 * t)),
           test::kTinyOrigin_m + size * (0.5 + 0.45 * std::sin(12.56 * t)), 2.0}};
}

StreamerOptions options_for(const Source& source, ClockKind clock) {
  std::uint64_t pages = 0;
  for (const NodeRecord& node : world().index.nodes) pages += node.page_bytes;
  return {.cap_bytes = smallest_cap_bytes(world().index, source.costs()) + pages / 2,
          .threads = 3,
          .clock = clock,
          .source_latency_s = clock == ClockKind::kVirtual ? 0.05 : 0,
          .source_bandwidth_bytes_per_s = clock == ClockKind::kVirtual ? 5e4 : 0.0,
          .tolerance = 0.02,
          .max_in_flight = 6};
}

// The event log, and every page of the rendered cut where it should be.
std::string drive(Source& source) {
  HeapPageSink sink;
  auto streamer = Streamer::open(source, options_for(source, ClockKind::kVirtual), sink);
  EXPECT_TRUE(streamer.ok());
  for (int frame = 0; frame < 120; ++frame) {
    const View view = view_at(frame / 120.0 + frame / 2 % 2 * 0.4);  // faster than pages come
    EXPECT_TRUE((*streamer)->advance(std::span(&view, 1), frame / 30.0).ok());
    for (const std::uint32_t node : (*streamer)->rendered_cut()) {
      const std::vector<std::uint32_t> page = test::page_of(world(), node);
      const auto held = sink.words().subspan((*streamer)->page_offset_words(node), page.size());
      EXPECT_TRUE(std::equal(page.begin(), page.end(), held.begin())) << node;
    }
  }
  const StreamerStatistics s = (*streamer)->statistics();
  EXPECT_GT(s.zones_loaded, 10U);
  EXPECT_GT(s.requests.cancelled, 0U);
  EXPECT_EQ(s.requests.failed, 0U);
  return s.event_log_xxh3;
}

TEST_F(HttpSource, pages_as_a_source_in_memory_does_byte_for_byte) {
  test::MemorySource memory(world().files);
  const std::string expected = drive(memory);
  const Running folder(folder_ / "world");
  EXPECT_EQ(drive(*open(folder.url())), expected);
  const Running archive(folder_ / "a.3tz");
  EXPECT_EQ(drive(*open(archive.url("a.3tz"))), expected);
}

TEST_F(HttpSource, a_streamer_may_stop_at_any_moment) {
  const Running server(folder_ / "world");
  std::mt19937 random(1);
  for (int round = 0; round < 20; ++round) {
    const auto source = open(server.url());
    HeapPageSink sink;
    auto streamer = Streamer::open(*source, options_for(*source, ClockKind::kWall), sink);
    ASSERT_TRUE(streamer.ok());
    for (int frame = 0; frame < round % 4 + 1; ++frame) {
      const View view = view_at(static_cast<double>(random() % 100) / 100);
      ASSERT_TRUE((*streamer)->advance(std::span(&view, 1), frame).ok());
    }
  }  // the ledger checks that it is empty
}

TEST_F(HttpSource, readings_are_taken_given_up_and_cancelled_by_many_threads) {
  const Running server(folder_ / "a.3tz");
  const auto source = open(server.url("a.3tz"));
  std::atomic<int> whole = 0;
  std::vector<std::thread> threads;
  for (unsigned t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      std::mt19937 random(t);
      for (int i = 0; i < 40; ++i) {
        const NodeRecord& node = world().index.nodes[random() % world().index.nodes.size()];
        const std::unique_ptr<AsyncRead> reading = source->begin(page_files(node));
        const unsigned fate = random() % 4;
        if (fate == 0) continue;
        std::thread canceller;
        if (fate == 1) canceller = std::thread([&] { reading->cancel(); });
        const auto bytes = reading->wait(0);
        if (bytes.ok()) {
          const auto& expected = world().files.at(node_file(node, "glb"));
          EXPECT_TRUE(std::equal(bytes->begin(), bytes->end(), expected.begin(), expected.end()));
          ++whole;
        } else {
          EXPECT_EQ(fate, 1U) << bytes.error().describe();
        }
        if (canceller.joinable()) canceller.join();
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_GE(whole, 40);
  EXPECT_EQ(source->statistics().failed, 0U);
}

TEST_F(HttpSource, a_server_out_of_reach_is_transient_and_one_that_is_back_serves) {
  auto server = std::make_unique<Running>(folder_ / "world");
  const int port = server->port();
  const auto source = open(server->url());
  const WorldIndex& index = world().index;
  ASSERT_TRUE(load_page(*source, index, 1).ok());
  server.reset();
  const auto failed = load_page(*source->begin(page_files(index.nodes[1])), index.nodes[1], index.materials.size());
  ASSERT_FALSE(failed.ok());
  EXPECT_EQ(failed.error().code, ErrorCode::kTransient);
  std::thread back([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    server = std::make_unique<Running>(folder_ / "world", port);
  });
  EXPECT_TRUE(load_page(*source, index, 1).ok()) << "is tried again";
  back.join();
  EXPECT_GT(source->statistics().failed, 1U);
}

TEST_F(HttpSource, what_is_not_there_is_to_be_asked_for_later) {
  const Running server(folder_ / "world");
  const auto source = open(server.url());
  NodeRecord node = world().index.nodes[1];
  node.cell_x = 999;
  const auto missing = source->begin(page_files(node))->wait(0);
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().code, ErrorCode::kMissing);
  EXPECT_EQ(missing.error().retry_after_s, 10);
  EXPECT_NE(missing.error().message.find("404"), std::string::npos);
  EXPECT_EQ(source->read("../secret", 1).error().code, ErrorCode::kArgument);
}

TEST(WebAddresses, names_are_put_before_the_query_and_encoded) {
  EXPECT_EQ(*url_below("http://host/a", "zones/0/0_0.glb"), "http://host/a/zones/0/0_0.glb");
  EXPECT_EQ(*url_below("http://host", "world.zcw"), "http://host/world.zcw");
  EXPECT_EQ(*url_below("https://u:p@host:81/a/?key=1#part", "x y%"), "https://u:p@host:81/a/x%20y%25?key=1");
  EXPECT_FALSE(url_below("http://", "a").ok());
  EXPECT_FALSE(url_below("http://host:99999/", "a").ok());
}

TEST(WebAddresses, shown_ones_have_no_secrets) {
  EXPECT_EQ(public_url("https://user:secret@host/a.3tz?key=secret#secret"), "https://host/a.3tz");
  EXPECT_EQ(public_url("http://user:secret@:/").find("secret"), std::string::npos);
}

}  // namespace
}  // namespace zc
