// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <random>

#include "baker/bvh_build.h"

namespace zc {
namespace {

using Vertices = std::vector<std::array<std::uint16_t, 3>>;
using Triangles = std::vector<std::array<std::uint32_t, 3>>;

struct Walk {
  const BvhFile& bvh;
  const Vertices& vertices;
  const Triangles& triangles;
  std::vector<int> seen;
  std::uint32_t depth = 0;

  void check_child(std::array<std::uint32_t, 3> low, std::array<std::uint32_t, 3> high, std::uint32_t ref,
                   std::uint32_t level) {
    if (ref == gpu::kRefNone) return;
    if ((ref & gpu::kRefLeaf) == 0) {
      ASSERT_LT(ref, bvh.nodes.size());
      node(ref, level + 1);
      return;
    }
    const std::uint32_t count = (ref >> gpu::kRefCountShift) & gpu::kRefCountMask;
    const std::uint32_t first = ref & gpu::kRefFirstMask;
    ASSERT_GE(count, 1U);
    ASSERT_LE(count, gpu::kLeafMaxTriangles);
    ASSERT_LE(first + count, bvh.order.size());
    for (std::uint32_t i = first; i < first + count; ++i) {
      ++seen[bvh.order[i]];
      for (const std::uint32_t v : triangles[bvh.order[i]]) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          ASSERT_GE(vertices[v][axis], low[axis]);
          ASSERT_LE(vertices[v][axis], high[axis]);
        }
      }
    }
  }

  void node(std::uint32_t index, std::uint32_t level) {
    depth = std::max(depth, level);
    const gpu::BvhNode& n = bvh.nodes[index];
    const auto lo = [](std::uint32_t w) { return w & 0xFFFFU; };
    const auto hi = [](std::uint32_t w) { return w >> 16U; };
    check_child({lo(n.min0_xy), hi(n.min0_xy), lo(n.min0_z_max0_x)},
                {hi(n.min0_z_max0_x), lo(n.max0_yz), hi(n.max0_yz)}, n.ref0, level);
    check_child({lo(n.min1_xy), hi(n.min1_xy), lo(n.min1_z_max1_x)},
                {hi(n.min1_z_max1_x), lo(n.max1_yz), hi(n.max1_yz)}, n.ref1, level);
  }
};

void expect_valid(const Vertices& vertices, const Triangles& triangles) {
  auto bvh = build_bvh(vertices, triangles);
  ASSERT_TRUE(bvh.ok());
  Walk walk{*bvh, vertices, triangles, std::vector<int>(triangles.size(), 0)};
  walk.node(0, 1);
  EXPECT_EQ(walk.depth, bvh->depth);
  EXPECT_LE(bvh->depth, gpu::kPageMaxDepth);
  EXPECT_TRUE(std::all_of(walk.seen.begin(), walk.seen.end(), [](int n) { return n == 1; }));
  EXPECT_LE(bvh->nodes.size(), triangles.size());
}

void random_mesh(std::size_t count, Vertices& vertices, Triangles& triangles) {
  std::mt19937 engine(7);
  const auto random = [&] { return static_cast<std::uint32_t>(engine()); };
  for (std::uint32_t i = 0; i < count; ++i) {
    std::array<std::uint32_t, 3> center = {random() % 65000, random() % 65000, random() % 65000};
    for (int k = 0; k < 3; ++k) {
      std::array<std::uint16_t, 3> v = {};
      for (std::size_t axis = 0; axis < 3; ++axis) v[axis] = static_cast<std::uint16_t>(center[axis] + random() % 500);
      vertices.push_back(v);
    }
    triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
}

TEST(BvhBuild, EveryTriangleIsInOneLeafWithinItsBox) {
  for (const std::size_t count : {1UL, 2UL, 4UL, 5UL, 8UL, 9UL, 100UL, 5000UL}) {
    Vertices vertices;
    Triangles triangles;
    random_mesh(count, vertices, triangles);
    expect_valid(vertices, triangles);
  }
}

TEST(BvhBuild, OneLeafHasARootWithAnAbsentChild) {
  auto bvh = build_bvh(Vertices{{1, 2, 3}, {4, 5, 6}, {7, 8, 0}}, Triangles{{0, 1, 2}});
  ASSERT_TRUE(bvh.ok());
  ASSERT_EQ(bvh->nodes.size(), 1U);
  EXPECT_EQ(bvh->depth, 1U);
  EXPECT_EQ(bvh->nodes[0].ref0, gpu::kRefLeaf | 1U << gpu::kRefCountShift);
  EXPECT_EQ(bvh->nodes[0].ref1, gpu::kRefNone);
  EXPECT_EQ(bvh->nodes[0].min1_xy, 0xFFFFFFFFU);
  EXPECT_EQ(bvh->nodes[0].max1_yz, 0U);
}

TEST(BvhBuild, EqualCentroidsAndSkewedSizesStayWithinTheDepthCap) {
  Vertices same = {{0, 0, 0}, {100, 0, 0}, {0, 100, 50}};
  expect_valid(same, Triangles(100000, {0, 1, 2}));
  // Sizes doubling: SAH would peel them off one by one.
  Vertices vertices;
  Triangles triangles;
  for (std::uint32_t copy = 0; copy < 500; ++copy) {
    for (std::uint32_t i = 0; i < 16; ++i) {
      const auto size = static_cast<std::uint16_t>(1U << i);
      const auto base = static_cast<std::uint32_t>(vertices.size());
      vertices.insert(vertices.end(), {{size, 0, 0}, {0, size, 0}, {static_cast<std::uint16_t>(copy), 0, size}});
      triangles.push_back({base, base + 1, base + 2});
    }
  }
  expect_valid(vertices, triangles);
}

TEST(BvhBuild, RefusesNothingAndDanglingTriangles) {
  EXPECT_FALSE(build_bvh({}, {}).ok());
  EXPECT_FALSE(build_bvh(Vertices{{0, 0, 0}}, Triangles{{0, 1, 2}}).ok());
}

TEST(BvhBuild, TimeGrowsBarelyFasterThanTheTriangles) {
  const auto build_s = [](std::size_t count) {
    Vertices vertices;
    Triangles triangles;
    random_mesh(count, vertices, triangles);
    const auto start = std::chrono::steady_clock::now();
    EXPECT_TRUE(build_bvh(vertices, triangles).ok());
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  const double small_s = build_s(25000);
  const double large_s = build_s(200000);
  RecordProperty("mtri_per_s", std::to_string(0.2 / large_s));
  EXPECT_LT(large_s / small_s, 32.0);  // eight times the triangles; a quadratic build takes 64 times as long
}

}  // namespace
}  // namespace zc
