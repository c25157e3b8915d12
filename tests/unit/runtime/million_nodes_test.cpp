// SPDX-License-Identifier: Apache-2.0
// A world of a million nodes is paged and drawn under a cap that its index alone exceeds: what is held grows with the
// pages that fit, not with the world.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "replay/host/stand_in_host.h"
#include "streamer/paging/memory_plan.h"
#include "streamer/streamer.h"
#include "tests/unit/streamer/tiny_world.h"

namespace zc {
namespace {

constexpr std::uint32_t kNodes = 1'000'000;
constexpr std::uint32_t kDepth = 10;
constexpr std::uint32_t kExtent = 16384;  // of every zone, in its own steps: 64 m at the finest
constexpr std::uint64_t kCap = 64U << 20U;

// Every zone of a depth has the same two files.
class RepeatedWorld final : public Source {
 public:
  RepeatedWorld() {
    for (std::uint32_t depth = 0; depth <= kDepth; ++depth) {
      NodeRecord& node = first_[depth];
      node.depth = depth;
      node.step_shift = kDepth - depth;
      const auto side = static_cast<std::int32_t>(kExtent << node.step_shift);
      node.bounds_max = {side, side, side};
      node.error_max_m = 0.25F * static_cast<float>(1U << node.step_shift);
      zones_[depth] = test::make_tiny_zone(16, 10, kExtent, depth, node);
    }
    WorldIndex index;
    index.materials.resize(2);
    index.header.bounds_max = first_[0].bounds_max;
    index.nodes.reserve(kNodes);
    add(index, -1, 0, 0, 0);
    for (std::uint32_t n = 0; index.nodes.size() < kNodes; ++n) {
      const NodeRecord parent = index.nodes[n];
      index.nodes[n].first_child = static_cast<std::uint32_t>(index.nodes.size());
      index.nodes[n].child_count = std::min<std::uint32_t>(4, kNodes - index.nodes[n].first_child);
      for (std::uint32_t c = 0; c < index.nodes[n].child_count; ++c)
        add(index, static_cast<std::int32_t>(n), parent.depth + 1, 2 * parent.cell_x + c % 2,
            2 * parent.cell_y + c / 2);
    }
    index_ = encode_world_index(index);
  }

  Result<std::vector<std::byte>> read(const std::string& name, std::uint64_t bytes) override {
    return read_all(name, bytes);
  }
  Result<std::vector<std::byte>> read_all(const std::string& name, std::uint64_t /*limit_bytes*/) override {
    const test::TinyZone& zone = zones_.at(std::stoul(name.substr(name.find('/') + 1)));  // zones/DEPTH/…
    return name.ends_with(".glb") ? zone.glb : zone.bvh;
  }
  Result<std::unique_ptr<SourceFile>> open(const std::string& /*name*/, std::uint64_t /*limit_bytes*/) override {
    return std::unique_ptr<SourceFile>(std::make_unique<InMemory>(index_));
  }
  [[nodiscard]] SourceCosts costs() const override { return {.whole_files = false}; }  // as a folder

 private:
  class InMemory final : public SourceFile {
   public:
    explicit InMemory(std::span<const std::byte> bytes) : bytes_(bytes) {}
    [[nodiscard]] std::uint64_t size_bytes() const override { return bytes_.size(); }
    Status read(std::uint64_t offset_bytes, std::span<std::byte> out) const override {
      std::ranges::copy(bytes_.subspan(offset_bytes, out.size()), out.begin());
      return {};
    }

   private:
    std::span<const std::byte> bytes_;
  };

  void add(WorldIndex& index, std::int32_t parent, std::uint32_t depth, std::uint32_t x, std::uint32_t y) const {
    NodeRecord node = first_[depth];
    node.parent = parent;
    node.cell_x = x;
    node.cell_y = y;
    const auto side = static_cast<std::int32_t>(kExtent << node.step_shift);
    node.origin = {static_cast<std::int32_t>(x) * side, static_cast<std::int32_t>(y) * side, 0};
    for (std::size_t a = 0; a < 3; ++a) {
      node.bounds_min[a] += node.origin[a];
      node.bounds_max[a] += node.origin[a];
    }
    index.nodes.push_back(node);
  }

  std::array<NodeRecord, kDepth + 1> first_;
  std::array<test::TinyZone, kDepth + 1> zones_;
  std::vector<std::byte> index_;
};

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

TEST(MillionNodes, ArePagedAndDrawnUnderACap) {
  RepeatedWorld source;
  auto device = Device::create({});
  ASSERT_TRUE(device.ok()) << device.error().describe();
  ZoneSet zones(**device);

  StreamerOptions options;
  options.cap_bytes = kCap;
  const auto start = std::chrono::steady_clock::now();
  auto streamer = Streamer::open(source, options, zones);
  ASSERT_TRUE(streamer.ok()) << streamer.error().describe();
  const double open_s = seconds_since(start);
  const std::uint64_t device_bytes = (*device)->allocated_bytes();

  HostOptions drawing;
  drawing.width = 320;
  drawing.height = 180;
  drawing.reflections = ReflectionMode::kProxy;
  const std::vector<gpu::MaterialEntry> materials(2, {0.5F, 0.5F, 0.5F, 0.1F, 0, 0, 0, 0});
  auto renderer = StandInHost::create(**device, zones, zones, materials, drawing);
  ASSERT_TRUE(renderer.ok()) << renderer.error().describe();
  double paging_s = 0;
  double drawing_s = 0;
  std::uint64_t rays = 0;
  constexpr int kFrames = 30;
  for (int f = 0; f < kFrames; ++f) {
    const double middle_m = 64.0 * (1U << kDepth) / 3;
    const View view{{middle_m + 20 * f, middle_m, 60}};
    const auto began = std::chrono::steady_clock::now();
    ASSERT_TRUE((*streamer)->advance(std::span(&view, 1), f / 30.0).ok());
    paging_s += seconds_since(began);
    FrameCamera camera;
    for (int axis = 0; axis < 3; ++axis)
      camera.lattice[static_cast<std::size_t>(axis)] = static_cast<std::int32_t>(std::llround(view.eye[axis] * 256));
    camera.right = {1, 0, 0};
    camera.up = {0, 0.6F, 0.8F};
    camera.forward = {0, 0.8F, -0.6F};
    std::vector<ZoneDraw> draws;
    for (std::uint32_t slot = 0; slot < zones.zone_count(); ++slot)
      draws.push_back({slot, zones.triangle_count(slot), 0});
    const auto drew = std::chrono::steady_clock::now();
    const auto frame = (*renderer)->render(camera, draws);
    ASSERT_TRUE(frame.ok()) << frame.error().describe();
    drawing_s += seconds_since(drew);
    rays += frame->counters.rays_proxy + frame->counters.rays_proxy_coarse;
    EXPECT_EQ(frame->counters.rays_lost, 0U);
  }
  const StreamerStatistics paging = (*streamer)->statistics();
  EXPECT_GT(rays, 0U);
  EXPECT_GT(paging.frame.cover_nodes, 100U);
  EXPECT_FALSE(paging.index_in_memory);
  EXPECT_LE(paging.ledger.peak_bytes, options.cap_bytes);
  EXPECT_EQ(paging.requests.failed, 0U);
  // A top level and a table for every node were 272 MB.
  EXPECT_LE(device_bytes - paging.pool_bytes, 8U << 20U);
  std::printf(
      "1,000,000 nodes, cap %lu MiB: opened in %.2f s; pool %.1f MB, %u pages at most, %u shown, %u resident; device "
      "%.1f MB, ledger %.1f MB; %lu index blocks read; a frame: paging %.1f ms, drawing %.1f ms\n",
      options.cap_bytes >> 20U, open_s, static_cast<double>(paging.pool_bytes) / 1e6, zones.max_pages(),
      paging.frame.cover_nodes, paging.frame.resident_nodes, static_cast<double>(device_bytes) / 1e6,
      static_cast<double>(paging.ledger.peak_bytes) / 1e6, paging.index_blocks_read, 1e3 * paging_s / kFrames,
      1e3 * drawing_s / kFrames);
}

}  // namespace
}  // namespace zc
