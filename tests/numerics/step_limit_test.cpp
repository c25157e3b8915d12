// SPDX-License-Identifier: Apache-2.0
// Rays that have to visit more nodes than the device's shaders can: lost and counted, never wrong, and found where the
// limit is higher.
#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include "runtime/tracer.h"
#include "streamer/world_format/bvh_page.h"
#include "tests/unit/streamer/tiny_world.h"

namespace zc {
namespace {

constexpr std::uint32_t kSlivers = 2500;
constexpr std::uint16_t kSide = 4096;  // lattice steps: 16 m
constexpr std::uint32_t kRays = 256;

// One page of the given triangles, in [0, 65535]³ lattice steps of the world's origin.
std::vector<std::uint32_t> page_of(ZoneMesh mesh) {
  NodeRecord record;
  record.bounds_max = {65535, 65535, 65535};
  record.triangle_count = static_cast<std::uint32_t>(mesh.triangles.size());
  record.vertex_count = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.materials.assign(mesh.triangles.size(), 0);
  const BvhFile bvh = test::build_median_bvh(mesh, record);
  record.bvh_node_count = static_cast<std::uint32_t>(bvh.nodes.size());
  record.bvh_depth = bvh.depth;
  record.reference_count = static_cast<std::uint32_t>(bvh.order.size());
  auto page = assemble_page(mesh, bvh, record, 1, "page");
  EXPECT_TRUE(page.ok()) << page.error().describe();
  return *page;
}

// Along the diagonal of a cube, so that its box is the cube and rays beside the diagonal miss it.
std::vector<std::uint32_t> sliver() {
  ZoneMesh mesh;
  mesh.vertices = {{0, 0, 0}, {kSide, kSide, kSide}, {kSide, kSide, kSide - 16}};
  mesh.triangles = {{0, 1, 2}};
  return page_of(std::move(mesh));
}

// Across x, behind the cube.
std::vector<std::uint32_t> wall() {
  ZoneMesh mesh;
  constexpr std::uint16_t x = 2 * kSide;
  mesh.vertices = {{x, 0, 0}, {x, kSide, 0}, {x, kSide, kSide}, {x, 0, kSide}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return page_of(std::move(mesh));
}

class DeepWorld : public testing::Test {
 protected:
  void SetUp() override {
    DeviceOptions options;
    options.validation = true;
    auto device = Device::create(options);
    ASSERT_TRUE(device.ok()) << device.error().describe();
    device_ = std::move(*device);
    zones_.emplace(*device_);
    const std::vector<std::uint32_t> one = sliver();
    const std::vector<std::uint32_t> last = wall();
    const std::uint64_t step = (one.size() + 7) / 8 * 8;
    ASSERT_TRUE(zones_->create(step * kSlivers + last.size(), kSlivers + 1).ok());
    std::vector<ShownPage> shown;
    for (std::uint32_t i = 0; i < kSlivers; ++i) {
      ASSERT_TRUE(zones_->upload(i * step, one).ok());
      shown.push_back({i * step, i, false});
    }
    wall_word_ = static_cast<std::uint32_t>(kSlivers * step);
    ASSERT_TRUE(zones_->upload(wall_word_, last).ok());
    shown.push_back({wall_word_, kSlivers, false});
    ASSERT_TRUE(zones_->show(shown).ok());
  }

  // Rays along x: beside the diagonal of the cube, and above it, where nothing but the wall's box is met.
  std::vector<TracedHit> trace(std::uint32_t rays_per_lane, std::uint32_t step_limit) {
    TracerOptions options;
    options.max_rays = kRays;
    options.trace.rays_per_lane = rays_per_lane;
    options.step_limit = step_limit;
    auto tracer = Tracer::create(*device_, *zones_, options);
    EXPECT_TRUE(tracer.ok()) << tracer.error().describe();
    std::vector<gpu::RayTask> rays;
    for (std::uint32_t i = 0; i < kRays; ++i) {
      const float across = 0.5F + 14.0F * static_cast<float>(i) / kRays;
      rays.push_back({-1, across, 15.5F - across, 0, 1, 0, 0, gpu::kNoSurface});
      if (i % 8 == 7) rays.back() = {9 + 16, 8, 8, 0, 1, 0, 0, gpu::kNoSurface};  // begins behind the cube
    }
    FrameCamera camera;
    camera.right = {1, 0, 0};
    camera.up = {0, 0, 1};
    camera.forward = {0, 1, 0};
    auto hits = (*tracer)->trace(camera, rays);
    EXPECT_TRUE(hits.ok()) << hits.error().describe();
    return *hits;
  }

  std::unique_ptr<Device> device_;
  std::optional<ZoneSet> zones_;
  std::uint32_t wall_word_ = 0;
};

TEST_F(DeepWorld, LosesRaysBeyondTheStepLimitAndGetsNoneWrong) {
  EXPECT_EQ(step_limit("llvmpipe (LLVM 15.0.6, 256 bits)"), 1900U);
  EXPECT_GT(step_limit("NVIDIA H200"), 20U * kSlivers);
  for (const std::uint32_t rays_per_lane : {0U, 4U}) {
    SCOPED_TRACE(rays_per_lane);
    // The rays that begin behind the cube are found at any limit; the others where the limit is beyond their nodes.
    for (const std::uint32_t limit : {1900U, 2 * kSlivers}) {
      std::size_t lost = 0;
      const std::vector<TracedHit> hits = trace(rays_per_lane, limit);
      for (std::size_t i = 0; i < hits.size(); ++i) {
        if (hits[i].page_word == gpu::kHitLost) {
          ++lost;
          continue;
        }
        ASSERT_EQ(hits[i].page_word, wall_word_) << i;
        EXPECT_NEAR(hits[i].t, i % 8 == 7 ? 7 : 33, 1e-3);
      }
      EXPECT_EQ(lost, limit == 1900 ? hits.size() / 8 * 7 : 0);
    }
  }
  EXPECT_EQ(device_->validation_messages(), 0U);
}

}  // namespace
}  // namespace zc
