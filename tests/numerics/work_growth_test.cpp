// SPDX-License-Identifier: GPL-3.0-or-later
// Simplification's work grows no faster than a zone, whatever lies on top of what. Work is what the processor does:
// baker/distance and baker/proxy are compiled once more for this test, and the compiler puts a call at the beginning of
// every basic block (-fsanitize-coverage=trace-pc). Their count is the same in every run, unlike times, and no budget
// in the code has a say in it.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>

#include "baker/distance/measure.h"
#include "baker/proxy/simplify.h"
#include "tests/unit/baker/stages.h"
#include "tests/unit/baker/test_city.h"

namespace {
std::uint64_t basic_blocks = 0;  // one thread at a time
}

extern "C" void __sanitizer_cov_trace_pc();
extern "C" void __sanitizer_cov_trace_pc() { ++basic_blocks; }

namespace zc {
namespace {

using test::SceneMaker;
using Shape = std::function<void(SceneMaker&, int count)>;

// Of work over triangles. n log n is 1.1 at these sizes; one part in five that grows as the square would be 1.25.
constexpr double kExponent = 1.25;
constexpr std::array<int, 3> kSizes = {4000, 8000, 16000};

double turn(int i, int count) { return 2 * M_PI * i / count; }

double work_of(const Shape& shape, int count) {
  SceneMaker maker;
  shape(maker, count);
  maker.object(ObjectKind::kObject);
  const CutScene scene = test::cut(test::snapped(std::move(maker.scene)), 1'000'000);
  EXPECT_EQ(scene.tree.zones.size(), 1U);
  const Zone& zone = scene.tree.zones[0];
  EXPECT_GT(zone.detail.faces.size(), 0.9 * count);
  const std::vector<std::uint16_t> appearances = appearance_classes(scene.materials);
  const SimplifyContext context = {&scene.tree.grid, scene.materials, appearances, 1.0 / 256, 0.1, 1'000'000, false};
  basic_blocks = 0;
  const DistanceBvh bvh(zone.detail, appearances);
  const Proxy proxy = simplify_leaf(context, zone, round_detail(zone.detail), {&zone.detail, &bvh, 0});
  EXPECT_GT(proxy.mesh.faces.size(), 0U);
  return static_cast<double>(basic_blocks);
}

void expect_near_linear(const Shape& shape) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  std::array<double, 3> work = {};
  for (std::size_t i = 0; i < work.size(); ++i) work[i] = work_of(shape, kSizes[i]);
  const auto exponent = [&](std::size_t from, std::size_t to) {
    return std::log2(work[to] / work[from]) / std::log2(static_cast<double>(kSizes[to]) / kSizes[from]);
  };
  std::printf("[ work     ] %.3g, %.3g, %.3g blocks: exponents %.2f, %.2f\n", work[0], work[1], work[2], exponent(0, 1),
              exponent(1, 2));
  EXPECT_GT(work[0], 100.0 * kSizes[0]) << "the code is not compiled to be counted";
  EXPECT_LE(exponent(0, 2), kExponent);
  EXPECT_LE(exponent(1, 2), kExponent);
}

TEST(WorkGrowth, OfPagesAtOneEdge) {
  expect_near_linear([](SceneMaker& maker, int count) {
    for (int i = 0; i < count; ++i)
      maker.triangle({0, 0, 0}, {0, 0, 100}, {std::cos(turn(i, count)) * 100, std::sin(turn(i, count)) * 100, 50}, 0);
  });
}

TEST(WorkGrowth, OfAFan) {
  expect_near_linear([](SceneMaker& maker, int count) {
    const auto at = [&](int i) {
      return glm::dvec3(std::cos(turn(i, count)) * 100, std::sin(turn(i, count)) * 100, 0.05 * (i * 7 % 3));
    };
    for (int i = 0; i < count; ++i) maker.triangle({0, 0, 0}, at(i), at((i + 1) % count), 0);
  });
}

void cross_triangles(SceneMaker& maker, int count) {
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> unit(0, 100);
  const auto point = [&] {
    const double x = unit(random);
    const double y = unit(random);
    return glm::dvec3(x, y, unit(random));
  };
  for (int i = 0; i < count; ++i) {
    const glm::dvec3 a = point();
    const glm::dvec3 b = point();
    maker.triangle(a, b, point(), static_cast<std::uint16_t>(i % 4));
  }
}

TEST(WorkGrowth, OfTrianglesThroughEachOther) { expect_near_linear(cross_triangles); }

// These grow faster up to the largest zone of a bake with default options, 16,000 triangles: below its bound a search
// takes what it needs. Even there they take less than the triangles through each other, whose growth is bounded.
TEST(WorkGrowth, NeedlesThatShareACornerTakeNoMoreThanTheHardest) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const double needles = work_of(
      [](SceneMaker& maker, int count) {
        for (int i = 0; i < count; ++i)
          maker.triangle({i * 0.01, 0, 0}, {(i + 1) * 0.01, 0, 0}, {count * 0.005, 100, 0}, 0);
      },
      kSizes.back());
  EXPECT_LE(needles, work_of(cross_triangles, kSizes.back()));
}

TEST(WorkGrowth, OfACity) {
  expect_near_linear([](SceneMaker& maker, int count) {
    const int across = static_cast<int>(std::sqrt(count / 10.0));
    maker.houses({0, 0, 0}, across, 11.3);
  });
}

}  // namespace
}  // namespace zc
