// SPDX-License-Identifier: GPL-3.0-or-later
// The GPU's closest hits against a plain double-precision loop over the same triangles.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "streamer/page_loader.h"
#include "tests/numerics/rendered_world.h"
#include "tests/unit/baker/test_city.h"

namespace zc {
namespace {

constexpr std::size_t kRays = 100000;

struct OracleTriangle {
  std::array<glm::dvec3, 3> corners;  // metres, relative to the camera's lattice point
  std::uint32_t node;
  std::uint32_t triangle;
};

class TraceOracle : public testing::TestWithParam<double> {};

glm::dvec3 corner_of(const NodeRecord& node, const std::array<std::int32_t, 3>& camera, double step_m, std::uint32_t x,
                     std::uint32_t y, std::uint32_t z) {
  glm::dvec3 p;
  const std::array<std::uint32_t, 3> q = {x, y, z};
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    p[axis] = (static_cast<double>(node.origin[i]) + static_cast<double>(q[i] << node.step_shift) - camera[i]) * step_m;
  }
  return p;
}

std::vector<OracleTriangle> decode_page(const std::vector<std::uint32_t>& page, std::uint32_t id,
                                        const NodeRecord& node, const std::array<std::int32_t, 3>& camera,
                                        double step_m) {
  std::vector<OracleTriangle> triangles;
  const std::uint32_t count = page[2];
  const std::uint32_t base = page[4];
  for (std::uint32_t t = 0; t < count; ++t) {
    const std::uint32_t* w = page.data() + base + std::size_t{t} * gpu::kPageTriangleWords;
    OracleTriangle out{{}, id, t};
    out.corners[0] = corner_of(node, camera, step_m, w[0] & 0xFFFFU, w[0] >> 16U, w[1] & 0xFFFFU);
    out.corners[1] = corner_of(node, camera, step_m, w[1] >> 16U, w[2] & 0xFFFFU, w[2] >> 16U);
    out.corners[2] = corner_of(node, camera, step_m, w[3] & 0xFFFFU, w[3] >> 16U, w[4] & 0xFFFFU);
    triangles.push_back(out);
  }
  return triangles;
}

// Distance along the ray, or infinity. Scalar triple products, nothing clever.
double intersect(const OracleTriangle& triangle, const glm::dvec3& origin, const glm::dvec3& direction) {
  const glm::dvec3 a = triangle.corners[0] - origin;
  const glm::dvec3 b = triangle.corners[1] - origin;
  const glm::dvec3 c = triangle.corners[2] - origin;
  const double u = glm::dot(direction, glm::cross(c, b));
  const double v = glm::dot(direction, glm::cross(a, c));
  const double w = glm::dot(direction, glm::cross(b, a));
  if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return INFINITY;
  const glm::dvec3 n = glm::cross(triangle.corners[1] - triangle.corners[0], triangle.corners[2] - triangle.corners[0]);
  const double facing = glm::dot(n, direction);
  if (facing == 0) return INFINITY;
  return glm::dot(n, a) / facing;
}

TEST_P(TraceOracle, GpuHitsEqualADoublePrecisionTraceOnRandomRays) {
  const double offset_m = GetParam();
  BakeOptions bake;
  bake.leaf_triangles = 600;
  RendererOptions options;
  options.width = 400;
  options.height = 256;
  test::RenderedWorld world;
  const Status opened = world.open(test::small_city({offset_m, -offset_m, offset_m / 1000}), bake, options);
  ASSERT_TRUE(opened.ok()) << opened.error().describe();
  const WorldIndex& index = world.index();
  const double step_m = index.step_m();

  // In the middle of the world.
  glm::dvec3 middle{};
  glm::dvec3 half{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const double center = (index.header.bounds_min[i] + index.header.bounds_max[i]) / 2.0;
    middle[axis] = (static_cast<double>(index.header.anchor[i]) + std::floor(center)) * step_m;
    half[axis] = (index.header.bounds_max[i] - center) * step_m;
  }
  const RenderCamera camera = world.camera(middle, {1, 0, 0}, {0, 0, 1}, {0, 1, 0});
  const auto cover = world.streamer().cover();
  ASSERT_GT(cover.size(), 4U);
  std::vector<OracleTriangle> triangles;
  for (const std::uint32_t id : cover) {
    const auto page = load_page(world.source(), index, id);
    ASSERT_TRUE(page.ok());
    const auto more = decode_page(*page, id, index.nodes[id], camera.lattice, step_m);
    triangles.insert(triangles.end(), more.begin(), more.end());
  }

  std::mt19937 random(7);
  std::uniform_real_distribution<float> unit(-1, 1);
  std::vector<gpu::RayTask> rays(kRays);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    gpu::RayTask& ray = rays[i];
    ray.origin_x = unit(random) * static_cast<float>(half.x);
    ray.origin_y = unit(random) * static_cast<float>(half.y);
    ray.origin_z = unit(random) * static_cast<float>(half.z);
    glm::vec3 d(unit(random), unit(random), unit(random));
    // A tenth of the rays run along axes and in axis planes.
    if (i % 10 == 0) d[static_cast<int>(i / 10 % 3)] = 0;
    if (i % 30 == 0) d[static_cast<int>(i / 30 % 3)] = 0;
    if (glm::length(d) < 1e-3F) d = {0, 0, -1};
    d = glm::normalize(d);
    ray.dir_x = d.x, ray.dir_y = d.y, ray.dir_z = d.z;
    ray.t_max = 1e6F;
  }
  double milliseconds = 0;
  const auto hits = world.renderer().trace(camera, rays, false, &milliseconds);
  ASSERT_TRUE(hits.ok()) << hits.error().describe();

  std::size_t same = 0, tied = 0, missed_by_both = 0, wrong = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const glm::dvec3 origin(rays[i].origin_x, rays[i].origin_y, rays[i].origin_z);
    const glm::dvec3 direction(rays[i].dir_x, rays[i].dir_y, rays[i].dir_z);
    double nearest = INFINITY;
    const OracleTriangle* expected = nullptr;
    for (const OracleTriangle& triangle : triangles) {
      const double t = intersect(triangle, origin, direction);
      if (t >= 0 && t < nearest) {
        nearest = t;
        expected = &triangle;
      }
    }
    const gpu::HitRecord& hit = (*hits)[i];
    ASSERT_NE(hit.zone, gpu::kHitLost) << "ray " << i;
    if (hit.zone == gpu::kNoZone || expected == nullptr) {
      (hit.zone == gpu::kNoZone && expected == nullptr) ? ++missed_by_both : ++wrong;
    } else if (cover[hit.zone] == expected->node && hit.triangle == expected->triangle) {
      // The same triangle must also be met at the same distance.
      std::abs(static_cast<double>(hit.t) - nearest) <= 1e-4 * std::max(1.0, nearest) ? ++same : ++wrong;
    } else {
      std::abs(static_cast<double>(hit.t) - nearest) <= 1e-4 * nearest ? ++tied : ++wrong;
    }
  }
  EXPECT_EQ(wrong, 0U) << same << " same, " << tied << " tied, " << missed_by_both << " missed by both";
  EXPECT_GT(same, kRays / 4);
  EXPECT_LT(tied, kRays / 100);
  EXPECT_EQ(world.device().validation_messages(), 0U);
  RecordProperty("triangles", static_cast<int>(triangles.size()));
  std::printf("%zu triangles: %zu same, %zu tied, %zu missed by both, %.1f ms on %s\n", triangles.size(), same, tied,
              missed_by_both, milliseconds, world.device().name().c_str());
}

INSTANTIATE_TEST_SUITE_P(WorldOffsets, TraceOracle, testing::Values(0.0, 1e6, 1e7),
                         [](const auto& at) { return "Metres" + std::to_string(static_cast<long>(at.param)); });

}  // namespace
}  // namespace zc
