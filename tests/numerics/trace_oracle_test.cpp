// SPDX-License-Identifier: GPL-3.0-or-later
// The GPU's closest hits against a plain double-precision loop over the same triangles.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <map>
#include <random>

#include "streamer/paging/page_loader.h"
#include "streamer/world_format/page_view.h"
#include "tests/numerics/rendered_world.h"
#include "tests/unit/baker/test_city.h"
#include "tests/unit/same_bytes.h"

namespace zc {
namespace {

constexpr std::size_t kRays = 100000;
// Every value of every option, and the stacks in shared memory with packets, whose lost rays they hold, and without.
constexpr std::array<TraceVariant, 10> kVariants = {{
    {0, gpu::kPoolStorage, false, 64},
    {0, gpu::kPoolTexels, false, 128},
    {0, gpu::kPoolStorage, true, 32},
    {0, gpu::kPoolTexels, true, 64},
    {2, gpu::kPoolStorage, false, 64},
    {2, gpu::kPoolTexels, true, 128},
    {4, gpu::kPoolStorage, false, 32},
    {4, gpu::kPoolTexels, false, 128},
    {8, gpu::kPoolStorage, true, 64},
    {8, gpu::kPoolTexels, false, 64},
}};

struct OracleTriangle {
  std::array<glm::dvec3, 3> corners;  // metres, relative to the camera's lattice point
  std::uint32_t page_word;
  std::uint32_t triangle;
};

class TraceOracle : public testing::TestWithParam<double> {};

std::vector<OracleTriangle> decode_page(const std::vector<std::uint32_t>& page, std::uint32_t page_word,
                                        const std::array<std::int32_t, 3>& camera, double step_m) {
  const PageView view(page);
  std::vector<OracleTriangle> triangles(view.header().triangle_count);
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const PageView::Triangle source = view.triangle(t);
    triangles[t].page_word = page_word;
    triangles[t].triangle = t;
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t axis = 0; axis < 3; ++axis)
        triangles[t].corners[k][static_cast<int>(axis)] =
            (static_cast<double>(source.corners[k][axis]) - camera[axis]) * step_m;
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

// Two thirds at random; the others in bundles as a flat mirror sends them, which packets are made of. A tenth runs
// along axes and in axis planes.
std::vector<gpu::RayTask> make_rays(const glm::dvec3& half) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> unit(-1, 1);
  std::vector<gpu::RayTask> rays(kRays);
  glm::vec3 corner{}, across{}, along{}, direction{};
  for (std::size_t i = 0; i < rays.size(); ++i) {
    glm::vec3 o(unit(random) * half.x, unit(random) * half.y, unit(random) * half.z);
    glm::vec3 d(unit(random), unit(random), unit(random));
    if (i % 10 == 0) d[static_cast<int>(i / 10 % 3)] = 0;
    if (i % 30 == 0) d[static_cast<int>(i / 30 % 3)] = 0;
    if (glm::length(d) < 1e-3F) d = {0, 0, -1};
    d = glm::normalize(d);
    const bool bundled = i >= kRays / 3 * 2;
    if (bundled && i % 64 == 0) {
      corner = o;
      direction = d;
      across = glm::vec3(unit(random), unit(random), unit(random));
      along = glm::vec3(unit(random), unit(random), unit(random));
    }
    if (bundled) {
      const auto x = static_cast<float>(i % 8) / 8;
      const auto y = static_cast<float>(i / 8 % 8) / 8;
      o = corner + across * x + along * y;
      d = glm::normalize(direction + (across * x + along * y) * 0.01F);
    }
    gpu::RayTask& ray = rays[i];
    ray.origin_x = o.x, ray.origin_y = o.y, ray.origin_z = o.z;
    ray.dir_x = d.x, ray.dir_y = d.y, ray.dir_z = d.z;
    ray.origin_normal = gpu::kNoSurface;
  }
  return rays;
}

struct Verdict {
  std::size_t same = 0, tied = 0, missed_by_both = 0, wrong = 0;
};

TEST_P(TraceOracle, GpuHitsEqualADoublePrecisionTraceOnRandomRays) {
  const double offset_m = GetParam();
  BakeOptions bake;
  bake.leaf_triangles = 600;
  HostOptions options;
  options.width = 400;
  options.height = 256;
  test::RenderedWorld world;
  const Status opened = world.open(test::small_city({offset_m, -offset_m, offset_m / 1000}), bake, options);
  ASSERT_TRUE(opened.ok()) << opened.error().describe();
  const IndexView index = world.index();
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
  const FrameCamera camera = world.camera(middle, {1, 0, 0}, {0, 0, 1}, {0, 1, 0});
  ASSERT_GT(world.proxy_zones().size(), 4U);
  std::vector<OracleTriangle> triangles;
  std::map<std::uint32_t, std::size_t> first_of_page;
  for (const gpu::ZoneEntry& zone : world.proxy_zones()) {
    const auto page = load_page(world.source(), index, zone.node);
    ASSERT_TRUE(page.ok());
    const auto more = decode_page(*page, zone.page_word, camera.lattice, step_m);
    first_of_page[zone.page_word] = triangles.size();
    triangles.insert(triangles.end(), more.begin(), more.end());
  }

  const std::vector<gpu::RayTask> rays = make_rays(half);
  std::vector<double> nearest(rays.size(), INFINITY);
  std::vector<const OracleTriangle*> expected(rays.size());
  const auto intersect_ray = [&](std::size_t i, const OracleTriangle& triangle) {
    const gpu::RayTask& r = rays[i];
    return intersect(triangle, {r.origin_x, r.origin_y, r.origin_z}, {r.dir_x, r.dir_y, r.dir_z});
  };
  for (std::size_t i = 0; i < rays.size(); ++i) {
    for (const OracleTriangle& triangle : triangles) {
      const double t = intersect_ray(i, triangle);
      if (t >= 0 && t < nearest[i]) {
        nearest[i] = t;
        expected[i] = &triangle;
      }
    }
  }

  std::uint32_t deepest = 1;
  for (std::uint32_t n = 0; n < index.nodes.size(); ++n) deepest = std::max(deepest, index.nodes[n].bvh_depth);
  // Every way that the kernels can be specialised finds the same.
  std::vector<TracedHit> first_hits;
  std::size_t first_tied = 0;
  for (const TraceVariant& variant : kVariants) {
    SCOPED_TRACE(trace_variant_name(variant));
    options.trace = variant;
    // Half of them with stacks for deeper pages than there are.
    options.page_depth = variant.width == 64 ? deepest : gpu::kPageMaxDepth;
    const Status remade = world.make_tracer(kRays, options.page_depth, options.trace);
    ASSERT_TRUE(remade.ok()) << remade.error().describe();
    ASSERT_EQ(world.tracer().trace_variant(), variant);
    double milliseconds = 0;
    const auto hits = world.tracer().trace(camera, rays, false, &milliseconds);
    ASSERT_TRUE(hits.ok()) << hits.error().describe();
    Verdict sum;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const TracedHit& hit = (*hits)[i];
      ASSERT_NE(hit.page_word, gpu::kHitLost) << "ray " << i;
      if (hit.page_word == gpu::kHitNone || expected[i] == nullptr) {
        (hit.page_word == gpu::kHitNone && expected[i] == nullptr) ? ++sum.missed_by_both : ++sum.wrong;
        continue;
      }
      ASSERT_TRUE(first_of_page.contains(hit.page_word)) << "ray " << i;
      const OracleTriangle& met = triangles[first_of_page[hit.page_word] + hit.triangle];
      const double tolerance = 1e-4 * std::max(1.0, nearest[i]);
      const bool in_place = std::abs(static_cast<double>(hit.t) - nearest[i]) <= tolerance &&
                            std::abs(intersect_ray(i, met) - nearest[i]) <= tolerance;
      in_place ? (&met == expected[i] ? ++sum.same : ++sum.tied) : ++sum.wrong;
    }
    EXPECT_EQ(sum.wrong, 0U) << sum.same << " same, " << sum.tied << " tied, " << sum.missed_by_both
                             << " missed by both";
    EXPECT_GT(sum.same, kRays / 4);
    EXPECT_LT(sum.tied, kRays / 100);
    // Of triangles in one place, either may be met.
    if (first_hits.empty()) {
      first_hits = *hits;
      first_tied = sum.tied;
    }
    std::size_t different = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) different += test::same_bytes(first_hits[i], (*hits)[i]) ? 0 : 1;
    EXPECT_LE(different, first_tied + sum.tied);
    const auto any = world.tracer().trace(camera, rays, true);
    ASSERT_TRUE(any.ok()) << any.error().describe();
    std::size_t disagree = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      ASSERT_NE((*any)[i].page_word, gpu::kHitLost) << "ray " << i;
      disagree += ((*any)[i].page_word == gpu::kHitNone) != (expected[i] == nullptr) ? 1 : 0;
    }
    EXPECT_EQ(disagree, 0U) << "rays of which any hit says otherwise";
    std::printf("%s, %zu triangles: %zu same, %zu tied, %zu missed by both, %.1f ms on %s\n",
                trace_variant_name(variant).c_str(), triangles.size(), sum.same, sum.tied, sum.missed_by_both,
                milliseconds, world.device().name().c_str());
  }
  // And so does the one that is measured to be the fastest.
  const Result<bool> chosen = world.tracer().choose_trace_variant(kRays);
  ASSERT_TRUE(chosen.ok()) << chosen.error().describe();
  const auto hits = world.tracer().trace(camera, rays);
  ASSERT_TRUE(hits.ok()) << hits.error().describe();
  EXPECT_EQ(std::memcmp(first_hits.data(), hits->data(), hits->size() * sizeof(TracedHit)), 0);
  EXPECT_EQ(world.device().validation_messages(), 0U);
}

INSTANTIATE_TEST_SUITE_P(WorldOffsets, TraceOracle, testing::Values(0.0, 1e6, 1e7),
                         [](const auto& at) { return "Metres" + std::to_string(static_cast<long>(at.param)); });

}  // namespace
}  // namespace zc
