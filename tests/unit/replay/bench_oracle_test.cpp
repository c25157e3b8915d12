// SPDX-License-Identifier: Apache-2.0
#include "replay/bench/oracle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "replay/bench/engines/sah_tree.h"

namespace zc::bench {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kStep = 0x1p-8F;

// A wall of two triangles, 8 m × 8 m at x = 10, separated by the diagonal y = z; the third one 5 m behind it.
const std::vector<BenchTriangle> kWall = {
    {{10, 0, 0, 10, 8, 0, 10, 8, 8}}, {{10, 0, 0, 10, 8, 8, 10, 0, 8}}, {{15, -50, -50, 15, 50, -50, 15, 0, 50}}};

BenchRay towards(float y, float z) { return {0, y, z, 1, 0, 0}; }

Verdict judge(const std::vector<BenchTriangle>& triangles, const BenchRay& ray, const BenchHit& reported) {
  const Oracle oracle(triangles);
  const std::vector<OracleHit> expected = oracle.trace(std::span(&ray, 1), 1);
  return bench::judge(oracle, ray, expected[0], reported, triangles.size());
}

std::vector<BenchTriangle> random_triangles(std::size_t count, std::mt19937& random) {
  std::uniform_int_distribution<int> place(-12800, 12800);
  std::uniform_int_distribution<int> reach(-1280, 1280);
  std::vector<BenchTriangle> triangles(count);
  for (BenchTriangle& triangle : triangles) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int at = place(random);
      for (std::size_t corner = 0; corner < 3; ++corner)
        triangle.v[3 * corner + axis] = static_cast<float>(at + reach(random)) * kStep;
    }
  }
  return triangles;
}

std::vector<BenchRay> random_rays(std::size_t count, std::mt19937& random) {
  std::uniform_real_distribution<float> place(-50, 50);
  std::uniform_real_distribution<float> unit(-1, 1);
  std::vector<BenchRay> rays(count);
  for (std::size_t i = 0; i < count; ++i) {
    glm::vec3 d(unit(random), unit(random), unit(random));
    if (i % 7 == 0) d[static_cast<int>(i % 3)] = 0;
    if (i % 21 == 0) d = {0, i % 2 == 0 ? 1 : -1, 0};
    d = glm::normalize(d);
    rays[i] = {place(random), place(random), place(random), d.x, d.y, d.z};
  }
  return rays;
}

OracleHit brute_force(const Oracle& oracle, const BenchRay& ray, std::uint32_t count) {
  const OracleRay wide = {{ray.ox, ray.oy, ray.oz}, {ray.dx, ray.dy, ray.dz}};
  OracleHit nearest;
  for (std::uint32_t i = 0; i < count; ++i) {
    const double t = intersect(wide, oracle.corners(i));
    if (t >= 0 && t < nearest.t) nearest = {t, i};
  }
  return nearest;
}

TEST(BenchOracle, EqualsALoopOverAllTrianglesAtAnyThreadCount) {
  std::mt19937 random(1);
  for (const std::size_t count : {1U, 2U, 5U, 600U}) {
    const auto triangles = random_triangles(count, random);
    const auto rays = random_rays(4000, random);
    const Oracle oracle(triangles);
    const auto hits = oracle.trace(rays, 1);
    const auto threaded = oracle.trace(rays, 3);
    std::size_t hit = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const OracleHit expected = brute_force(oracle, rays[i], static_cast<std::uint32_t>(count));
      ASSERT_EQ(hits[i].triangle, expected.triangle) << "ray " << i;
      ASSERT_EQ(hits[i].t, expected.t) << "ray " << i;
      ASSERT_EQ(threaded[i].triangle, expected.triangle) << "ray " << i;
      hit += expected.triangle != kMiss ? 1 : 0;
    }
    if (count == 600) {
      EXPECT_GT(hit, rays.size() / 10);
    }
  }
}

TEST(BenchOracle, OfOverlappingTrianglesTheFirstIsHitAndEitherMayBeReported) {
  const std::vector<BenchTriangle> twice(5, kWall[0]);
  EXPECT_EQ(Oracle(twice).trace({{0, 4, 1}, {1, 0, 0}}).triangle, 0U);
  EXPECT_EQ(judge(twice, towards(4, 1), {10, 0}), Verdict::kSame);
  EXPECT_EQ(judge(twice, towards(4, 1), {10, 4}), Verdict::kTied);
}

TEST(BenchOracle, DistanceToATriangleIsThatToItsNearestPoint) {
  const std::array<glm::dvec3, 3> corners = {glm::dvec3(0, 0, 0), glm::dvec3(4, 0, 0), glm::dvec3(0, 4, 0)};
  EXPECT_DOUBLE_EQ(distance_to_triangle({1, 1, -3}, corners), 3);
  EXPECT_DOUBLE_EQ(distance_to_triangle({2, -2, 0}, corners), 2);
  EXPECT_DOUBLE_EQ(distance_to_triangle({-3, -4, 0}, corners), 5);
  EXPECT_DOUBLE_EQ(distance_to_triangle({4, 4, 0}, corners), std::sqrt(8.0));
}

TEST(BenchVerdict, TheOraclesOwnHitIsTheSame) {
  EXPECT_EQ(judge(kWall, towards(4, 1), {10, 0}), Verdict::kSame);
  EXPECT_EQ(judge(kWall, towards(4, 1), {std::nextafter(10.0F, 11.0F), 0}), Verdict::kSame);
  EXPECT_EQ(judge(kWall, {0, 4, 1, -1, 0, 0}, {kInfinity, kMiss}), Verdict::kMissedByBoth);
}

TEST(BenchVerdict, OnASharedEdgeEitherTriangleTiesAndALeakIsAMismatch) {
  for (const float at : {1.0F, 3.3F, 7.0F}) {
    const BenchRay ray = towards(at, at);
    for (const std::uint32_t triangle : {0U, 1U}) {
      const Verdict verdict = judge(kWall, ray, {10, triangle});
      EXPECT_TRUE(verdict == Verdict::kSame || verdict == Verdict::kTied) << at;
    }
    EXPECT_EQ(judge(kWall, ray, {15, 2}), Verdict::kMismatch) << at;
    EXPECT_EQ(judge(kWall, ray, {kInfinity, kMiss}), Verdict::kMismatch) << at;
  }
  // A few steps away from the edge the neighbour is wrong.
  EXPECT_EQ(judge(kWall, towards(3, 3 - 2 * kStep), {10, 1}), Verdict::kMismatch);
}

TEST(BenchVerdict, AtASilhouetteBothSidesTieWithinRoundingOnly) {
  const float rounding = 15 * 0x1p-24F;
  EXPECT_EQ(judge(kWall, towards(4, rounding), {15, 2}), Verdict::kTied);
  EXPECT_EQ(judge(kWall, towards(4, rounding), {10, 0}), Verdict::kSame);
  EXPECT_EQ(judge(kWall, towards(4, -rounding), {10, 0}), Verdict::kTied);
  EXPECT_EQ(judge(kWall, towards(4, -rounding), {15, 2}), Verdict::kSame);
  EXPECT_EQ(judge(kWall, towards(4, kStep), {15, 2}), Verdict::kMismatch);
  EXPECT_EQ(judge(kWall, towards(4, -kStep), {10, 0}), Verdict::kMismatch);
  const std::vector<BenchTriangle> alone = {kWall[0]};
  EXPECT_EQ(judge(alone, towards(4, rounding), {kInfinity, kMiss}), Verdict::kTied);
  EXPECT_EQ(judge(alone, towards(4, kStep), {kInfinity, kMiss}), Verdict::kMismatch);
}

TEST(BenchVerdict, WhetherAnythingIsHitTiesWithinRoundingOfASilhouetteOnly) {
  const std::vector<BenchTriangle> alone = {kWall[0]};
  const Oracle oracle(alone);
  const auto judged = [&](const BenchRay& ray, const BenchHit& reported) {
    return judge_any_hit(oracle, ray, oracle.trace(std::span(&ray, 1), 1)[0], reported, alone.size());
  };
  const BenchHit miss{kInfinity, kMiss};
  const float rounding = 15 * 0x1p-24F;
  EXPECT_EQ(judged(towards(4, 1), {3, 0}), Verdict::kSame);  // how far is not asked
  EXPECT_EQ(judged(towards(4, 1), miss), Verdict::kMismatch);
  EXPECT_EQ(judged(towards(4, 1), {0, 1}), Verdict::kMismatch);  // no such triangle: what an unwritten hit looks like
  EXPECT_EQ(judged(towards(4, rounding), miss), Verdict::kTied);
  EXPECT_EQ(judged(towards(4, -rounding), {10, 0}), Verdict::kTied);
  EXPECT_EQ(judged(towards(4, -rounding), miss), Verdict::kMissedByBoth);
  EXPECT_EQ(judged(towards(4, kStep), miss), Verdict::kMismatch);
  EXPECT_EQ(judged(towards(4, -kStep), {10, 0}), Verdict::kMismatch);
}

TEST(BenchVerdict, PlantedWrongHitsAreMismatches) {
  const BenchRay ray = towards(4, 1);
  EXPECT_EQ(judge(kWall, ray, {15, 2}), Verdict::kMismatch);          // the surface behind
  EXPECT_EQ(judge(kWall, ray, {10, 1}), Verdict::kMismatch);          // a triangle beside the ray
  EXPECT_EQ(judge(kWall, ray, {10 + kStep, 0}), Verdict::kMismatch);  // another distance
  EXPECT_EQ(judge(kWall, ray, {0, 0}), Verdict::kMismatch);           // what an unwritten hit looks like
  EXPECT_EQ(judge(kWall, ray, {kInfinity, kMiss}), Verdict::kMismatch);
  EXPECT_EQ(judge(kWall, ray, {kInfinity, 0}), Verdict::kMismatch);
  EXPECT_EQ(judge(kWall, ray, {std::nanf(""), 0}), Verdict::kMismatch);
  EXPECT_EQ(judge(kWall, ray, {10, 3}), Verdict::kMismatch);                   // no such triangle
  EXPECT_EQ(judge(kWall, {20, 4, 1, 1, 0, 0}, {-10, 0}), Verdict::kMismatch);  // behind the ray
}

TEST(BenchVerdict, AtGrazingIncidenceTheDistanceMayMoveByRoundingOverTheCosine) {
  // A floor 1 m below, met 1000 m ahead.
  const std::vector<BenchTriangle> floor = {{{-100, -4000, -1, 4000, 0, -1, -100, 4000, -1}}};
  const glm::vec3 d = glm::normalize(glm::vec3(1000, 0, -1));
  const BenchRay ray = {0, 0, 0, d.x, d.y, d.z};
  const auto t = static_cast<float>(Oracle(floor).trace({{0, 0, 0}, d}).t);
  const double bound = kRoundings * 0x1p-24 * std::sqrt(16.0e6 + 10001);
  const auto slack = static_cast<float>(bound * 1000);
  EXPECT_EQ(judge(floor, ray, {t + 0.9F * slack, 0}), Verdict::kSame);
  EXPECT_EQ(judge(floor, ray, {t - 0.9F * slack, 0}), Verdict::kSame);
  EXPECT_EQ(judge(floor, ray, {t + 1.2F * slack, 0}), Verdict::kMismatch);
}

TEST(BenchVerdict, CountsAddUpAndNameTheFirstMismatch) {
  std::mt19937 random(2);
  const auto triangles = random_triangles(300, random);
  const auto rays = random_rays(3000, random);
  const Oracle oracle(triangles);
  const auto expected = oracle.trace(rays, 2);
  std::vector<BenchHit> reported;
  for (const OracleHit& hit : expected) reported.push_back({static_cast<float>(hit.t), hit.triangle});
  Comparison comparison = compare(oracle, rays, expected, reported, triangles.size(), false, 2);
  EXPECT_EQ(comparison.mismatches, 0U);
  EXPECT_EQ(comparison.same + comparison.missed_by_both, rays.size());
  reported[77] = {1e-3F, 299};
  reported[1234] = {1e-3F, 299};
  comparison = compare(oracle, rays, expected, reported, triangles.size(), false, 2);
  EXPECT_EQ(comparison.mismatches, 2U);
  EXPECT_EQ(comparison.first_mismatch, 77U);
  EXPECT_EQ(comparison.same + comparison.tied + comparison.missed_by_both + comparison.mismatches, rays.size());
}

TEST(BenchSahTree, HoldsEveryTriangleOnceInsideItsBoxes) {
  std::mt19937 random(3);
  auto triangles = random_triangles(2000, random);
  triangles.resize(4000, triangles[5]);  // equal centroids: only halving parts them
  const SahTree tree = build_sah_tree(triangles, {4, 1});
  EXPECT_LE(tree.depth, 64U);
  std::vector<int> seen(triangles.size(), 0);
  for (const SahNode& node : tree.nodes) {
    if (node.count == 0) {
      for (const std::uint32_t child : {node.first, node.first + 1}) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          EXPECT_LE(node.box.min[axis], tree.nodes[child].box.min[axis]);
          EXPECT_GE(node.box.max[axis], tree.nodes[child].box.max[axis]);
        }
      }
      continue;
    }
    EXPECT_LE(node.count, 4U);
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      ++seen[tree.order[i]];
      for (std::size_t k = 0; k < 9; ++k) {
        EXPECT_LE(node.box.min[k % 3], triangles[tree.order[i]].v[k]);
        EXPECT_GE(node.box.max[k % 3], triangles[tree.order[i]].v[k]);
      }
    }
  }
  EXPECT_TRUE(std::ranges::all_of(seen, [](int times) { return times == 1; }));
}

}  // namespace
}  // namespace zc::bench
