// SPDX-License-Identifier: GPL-3.0-or-later
// Wide trees and the pages made of them. What a page must keep is checked by verify_page, which world_format_test holds
// to account; here an own walk finds every triangle again.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <random>

#include "baker/bvh/binned_sah.h"
#include "baker/bvh/build_page.h"
#include "baker/bvh/build_wide.h"
#include "baker/bvh/page_nodes.h"
#include "baker/bvh/simulate.h"
#include "shaders/shared/page_node.h"
#include "streamer/world_format/page_view.h"

namespace zc {
namespace {

using Corners = std::array<PageView::Point, 3>;

struct Walk {
  const PageView& page;
  std::vector<Corners> found;
  std::uint32_t depth = 0;

  void node(std::uint32_t index, std::uint32_t level) {
    depth = std::max(depth, level);
    const gpu::PageNode n = page.node(index);
    std::uint32_t position = leaf_mask(n) != 0 ? page.first_triangle(index) : 0;
    std::uint32_t child = index + n.child_offset / gpu::kPageNodeWords;
    for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
      for (std::uint32_t k = leaf_count(n, slot); k > 0; --k) {
        const WideNodeBox box = child_box(n, slot);
        found.push_back(page.triangle(position++).corners);
        for (const PageView::Point& p : found.back()) {
          for (std::size_t axis = 0; axis < 3; ++axis) {
            EXPECT_GE(p[axis], box.min[axis]);
            EXPECT_LE(p[axis], box.max[axis]);
          }
        }
      }
      if ((inner_mask(n) >> slot & 1U) != 0) node(child++, level + 1);
    }
  }
};

// Of trees that keep triangles whole: each in one leaf, whose box holds all of it. EveryMethodCoversEveryPoint… speaks
// of those that split them.
void expect_valid(ZoneMesh mesh, BvhBuildOptions options = {}) {
  options.method = BvhMethod::kSweepReinsert;
  mesh.materials.resize(mesh.triangles.size());
  NodeRecord record;
  record.origin = {-4096, 8192, 64};
  record.step_shift = 3;
  record.triangle_count = static_cast<std::uint32_t>(mesh.triangles.size());
  const auto tree = build_wide_bvh(bvh_triangles(mesh), options);
  ASSERT_TRUE(tree.ok()) << tree.error().describe();
  const BvhFile bvh = lay_out_bvh(*tree, mesh, {}, record);
  record.reference_count = static_cast<std::uint32_t>(bvh.order.size());
  record.bvh_node_count = static_cast<std::uint32_t>(bvh.nodes.size());
  record.bvh_depth = bvh.depth;
  const auto words = assemble_page(mesh, bvh, record, 70000, "page");
  ASSERT_TRUE(words.ok()) << words.error().describe();

  const PageView page(*words);
  Walk walk{page, {}};
  walk.node(0, 1);
  EXPECT_EQ(walk.depth, bvh.depth);
  EXPECT_LE(bvh.depth, gpu::kPageMaxDepth);
  std::vector<Corners> expected;
  for (const auto& triangle : mesh.triangles) {
    Corners corners{};
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t axis = 0; axis < 3; ++axis)
        corners[k][axis] = record.origin[axis] + 8 * std::int32_t{mesh.vertices[triangle[k]][axis]};
    expected.push_back(corners);
  }
  std::ranges::sort(expected);
  std::ranges::sort(walk.found);
  EXPECT_TRUE(walk.found == expected);
}

ZoneMesh random_mesh(std::size_t count) {
  ZoneMesh mesh;
  std::mt19937 engine(7);
  const auto random = [&] { return static_cast<std::uint32_t>(engine()); };
  for (std::uint32_t i = 0; i < count; ++i) {
    std::array<std::uint32_t, 3> center = {random() % 65000, random() % 65000, random() % 65000};
    for (int k = 0; k < 3; ++k) {
      std::array<std::uint16_t, 3> v = {};
      for (std::size_t axis = 0; axis < 3; ++axis) v[axis] = static_cast<std::uint16_t>(center[axis] + random() % 500);
      mesh.vertices.push_back(v);
    }
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

TEST(WideBvh, EveryTriangleIsInOneLeafWithinItsBox) {
  for (const std::size_t count : {1UL, 2UL, 4UL, 5UL, 8UL, 9UL, 100UL, 5000UL}) expect_valid(random_mesh(count));
}

TEST(WideBvh, EveryWidthAndLeafSizeMakesAPage) {
  for (const std::uint32_t width : {2U, 4U, 8U}) {
    for (const std::uint32_t leaf : {1U, 3U, 4U}) {
      BvhBuildOptions options;
      options.collapse.width = width;
      options.collapse.leaf_triangles = leaf;
      expect_valid(random_mesh(700), options);
    }
  }
}

TEST(WideBvh, EqualCentroidsAndSkewedSizesStayWithinTheDepthCap) {
  ZoneMesh same;
  same.vertices = {{0, 0, 0}, {100, 0, 0}, {0, 100, 50}};
  same.triangles.assign(20000, {0, 1, 2});
  expect_valid(same);
  // Sizes doubling: SAH would peel them off one by one.
  ZoneMesh skewed;
  for (std::uint32_t copy = 0; copy < 500; ++copy) {
    for (std::uint32_t i = 0; i < 16; ++i) {
      const auto size = static_cast<std::uint16_t>(1U << i);
      const auto base = static_cast<std::uint32_t>(skewed.vertices.size());
      skewed.vertices.insert(skewed.vertices.end(),
                             {{size, 0, 0}, {0, size, 0}, {static_cast<std::uint16_t>(copy), 0, size}});
      skewed.triangles.push_back({base, base + 1, base + 2});
    }
  }
  expect_valid(skewed);
}

TEST(WideBvh, ATreeTooDeepForAPageIsCollapsedByLevels) {
  // A chain: each node has a leaf and the rest, down to the depth that builders keep.
  BinaryTree chain;
  for (std::uint32_t i = 0; i < kBinaryDepthMax; ++i)
    chain.references.push_back({{{static_cast<std::uint16_t>(i), 0, 0}, {static_cast<std::uint16_t>(i), 9, 9}}, i});
  chain.nodes.emplace_back();
  for (std::uint32_t i = 0, node = 0; i < kBinaryDepthMax; ++i) {
    chain.nodes[node].box = BvhBox{{static_cast<std::uint16_t>(i), 0, 0}, {kBinaryDepthMax - 1, 9, 9}};
    if (i + 1 == kBinaryDepthMax) {
      chain.nodes[node].reference = i;
      break;
    }
    const auto child = static_cast<std::uint32_t>(chain.nodes.size());
    chain.nodes[node].left = child;
    chain.nodes.resize(child + 2);
    chain.nodes[child].box = chain.references[i].box;
    chain.nodes[child].reference = i;
    node = child + 1;
  }
  CollapseOptions options;
  options.width = 2;
  options.leaf_triangles = 1;
  EXPECT_GT(collapse(chain, options).depth, gpu::kPageMaxDepth);
  options.by_levels = true;
  const WideTree tree = collapse(chain, options);
  EXPECT_LE(tree.depth, gpu::kPageMaxDepth);
  EXPECT_EQ(tree.references.size(), chain.references.size());
}

TEST(WideBvh, AClusterEndsWhereVerticesOrMaterialsRunOut) {
  ZoneMesh mesh = random_mesh(2000);  // no vertex is shared
  expect_valid(mesh);
  ZoneMesh colourful;
  colourful.vertices = {{0, 0, 0}, {100, 0, 0}, {0, 100, 50}};
  for (std::uint32_t i = 0; i < 3000; ++i) {
    colourful.triangles.push_back({0, 1, 2});
    colourful.materials.push_back(static_cast<std::uint16_t>(i * 21));
  }
  NodeRecord record;
  record.triangle_count = 3000;
  const auto tree = build_wide_bvh(bvh_triangles(colourful), {});
  ASSERT_TRUE(tree.ok());
  const BvhFile bvh = lay_out_bvh(*tree, colourful, {}, record);
  EXPECT_GE(bvh.clusters.size(), 3000U / gpu::kPaletteMax);
  record.reference_count = 3000;
  record.bvh_node_count = static_cast<std::uint32_t>(bvh.nodes.size());
  record.bvh_depth = bvh.depth;
  const auto words = assemble_page(colourful, bvh, record, 3000 * 21, "page");
  ASSERT_TRUE(words.ok()) << words.error().describe();
  const PageView page(*words);
  for (std::uint32_t i = 0; i < 3000; ++i) EXPECT_EQ(page.triangle(i).material, colourful.materials[bvh.order[i]]);
}

TEST(WideBvh, RefusesNothing) { EXPECT_FALSE(build_wide_bvh({}, {}).ok()); }

TEST(WideBvh, TimeGrowsBarelyFasterThanTheTriangles) {
  const auto build_s = [](std::size_t count) {
    const std::vector<BvhTriangle> triangles = bvh_triangles(random_mesh(count));
    const auto start = std::chrono::steady_clock::now();
    EXPECT_TRUE(build_wide_bvh(triangles, {}).ok());
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  const double small_s = build_s(25000);
  const double large_s = build_s(200000);
  RecordProperty("mtri_per_s", std::to_string(0.2 / large_s));
  EXPECT_LT(large_s / small_s, 32.0);  // eight times the triangles; a quadratic build takes 64 times as long
}

// Random triangles, some of them long and thin across the zone: what spatial splits are for.
std::vector<BvhTriangle> slivers_and_crumbs(std::size_t count) {
  std::mt19937 random(11);
  std::vector<BvhTriangle> triangles(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t reach = i % 10 == 0 ? 60000 : 300;
    std::array<std::uint32_t, 3> from;
    for (std::uint32_t& v : from) v = static_cast<std::uint32_t>(random() % (65536 - reach));
    for (auto& corner : triangles[i])
      for (std::size_t axis = 0; axis < 3; ++axis)
        corner[axis] = static_cast<std::uint16_t>(from[axis] + random() % reach);
  }
  return triangles;
}

std::uint32_t leaf_references(const WideTree& tree) {
  std::uint32_t sum = 0;
  for (const WideNode& node : tree.nodes)
    for (const WideChild& child : node.slots) sum += child.kind == WideChild::Kind::kLeaf ? child.count : 0;
  return sum;
}

TEST(BvhMethods, EveryMethodCoversEveryPointOfEveryTriangle) {
  const std::vector<BvhTriangle> triangles = slivers_and_crumbs(3000);
  for (const BvhMethodName& entry : bvh_methods()) {
    SCOPED_TRACE(entry.name);
    BvhBuildOptions options;
    options.method = entry.method;
    const Result<WideTree> tree = build_wide_bvh(triangles, options);
    ASSERT_TRUE(tree.ok());
    EXPECT_LE(tree->depth, gpu::kPageMaxDepth);
    EXPECT_EQ(leaf_references(*tree), tree->references.size());
    std::vector<std::vector<BvhBox>> boxes(triangles.size());  // of the leaves that hold the triangle
    for (const WideNode& node : tree->nodes)
      for (const WideChild& child : node.slots)
        for (std::uint32_t i = 0; child.kind == WideChild::Kind::kLeaf && i < child.count; ++i)
          boxes[tree->references[child.first + i].triangle].push_back(child.box);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(0, 1);
    std::size_t uncovered = 0;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      for (int sample = 0; sample < 20; ++sample) {
        double u = unit(random), v = unit(random);
        if (u + v > 1) u = 1 - u, v = 1 - v;
        std::array<double, 3> p;
        for (std::size_t axis = 0; axis < 3; ++axis)
          p[axis] = triangles[t][0][axis] * (1 - u - v) + triangles[t][1][axis] * u + triangles[t][2][axis] * v;
        const bool covered = std::ranges::any_of(boxes[t], [&](const BvhBox& box) {
          for (std::size_t axis = 0; axis < 3; ++axis)
            if (p[axis] < box.min[axis] - 1e-6 || p[axis] > box.max[axis] + 1e-6) return false;
          return true;
        });
        uncovered += covered ? 0 : 1;
      }
    }
    EXPECT_EQ(uncovered, 0U);
  }
}

TEST(BvhMethods, SpatialSplitsKeepTheirBoundOnCopies) {
  const std::vector<BvhTriangle> triangles = slivers_and_crumbs(3000);
  BvhBuildOptions options;
  options.method = BvhMethod::kSbvh;
  for (const float most : {0.0F, 0.1F, 0.3F}) {
    options.sbvh.max_duplication = most;
    const Result<WideTree> tree = build_wide_bvh(triangles, options);
    ASSERT_TRUE(tree.ok());
    EXPECT_GE(tree->references.size(), triangles.size());
    EXPECT_LE(static_cast<float>(tree->references.size()), (1 + most) * 3000);
  }
  EXPECT_GT(build_wide_bvh(triangles, options)->references.size(), triangles.size()) << "nothing was split";
}

TEST(BvhMethods, EqualBoxesAndLinesKeepTheDepth) {
  std::vector<BvhTriangle> same(20000, BvhTriangle{{{10, 10, 10}, {5000, 9, 30}, {20, 4000, 6}}});
  std::vector<BvhTriangle> lines(20000);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto x = static_cast<std::uint16_t>(i);
    lines[i] = {{{0, 0, 0}, {x, x, x}, {static_cast<std::uint16_t>(x + 1), x, x}}};
  }
  for (const BvhMethodName& entry : bvh_methods()) {
    SCOPED_TRACE(entry.name);
    BvhBuildOptions options;
    options.method = entry.method;
    for (const auto* triangles : {&same, &lines}) {
      const Result<WideTree> tree = build_wide_bvh(*triangles, options);
      ASSERT_TRUE(tree.ok());
      EXPECT_LE(tree->depth, gpu::kPageMaxDepth);
    }
  }
}

TEST(BvhMethods, SimulatedRaysFindWhatEveryTriangleInTurnFinds) {
  const std::vector<BvhTriangle> triangles = slivers_and_crumbs(1500);
  const std::vector<SampleRay> rays = make_sample_rays(triangles);
  for (const BvhMethodName& entry : bvh_methods()) {
    SCOPED_TRACE(entry.name);
    BvhBuildOptions options;
    options.method = entry.method;
    const Result<WideTree> tree = build_wide_bvh(triangles, options);
    ASSERT_TRUE(tree.ok());
    const TreeSimulation simulation(*tree, triangles);
    TraceCounts counts;
    std::size_t hits = 0;
    for (const SampleRay& ray : rays) {
      SampleHit expected;
      for (std::uint32_t t = 0; t < triangles.size(); ++t) test_triangle(triangles[t], t, ray, expected);
      const SampleHit hit = simulation.trace(ray, counts);
      EXPECT_EQ(hit.triangle, expected.triangle);
      hits += hit.triangle != SampleHit{}.triangle ? 1 : 0;
    }
    EXPECT_GT(hits, rays.size() / 4);
    EXPECT_LT(counts.triangles, rays.size() * triangles.size() / 4);
  }
}

TEST(BvhMethods, AutoScoresNoWorseThanWhatItChoosesFrom) {
  for (const auto& triangles : {bvh_triangles(random_mesh(2000)), slivers_and_crumbs(3000)}) {
    const std::vector<SampleRay> rays = make_sample_rays(triangles);
    BvhBuildOptions options;
    const auto score = [&](BvhMethod method) {
      options.method = method;
      const Result<WideTree> tree = build_wide_bvh(triangles, options);
      const double bytes =
          (80.0 * static_cast<double>(tree->nodes.size()) + 8.0 * static_cast<double>(tree->references.size())) /
          static_cast<double>(triangles.size());
      EXPECT_LE(tree->depth, options.depth_preferred);
      const double cost = simulated_cost(*tree, triangles, rays) * (1 + options.byte_weight * bytes);
      return bytes > options.bytes_per_triangle_max ? cost * 1e3 * bytes : cost;
    };
    const double chosen = score(BvhMethod::kAuto);
    EXPECT_LE(chosen, score(BvhMethod::kBinnedReinsert));
    EXPECT_LE(chosen, score(BvhMethod::kSbvh));
  }
}

TEST(BvhMethods, ReinsertionLowersTheSumOfAreas) {
  const auto areas = [](const BinaryTree& tree) {
    std::int64_t sum = 0;
    for (const BinaryNode& node : tree.nodes) sum += node.is_leaf() ? 0 : node.box.half_area();
    return sum;
  };
  for (const std::size_t count : {3UL, 4UL, 40UL, 3000UL}) {
    const std::vector<BvhTriangle> triangles = slivers_and_crumbs(count);
    BinaryTree tree = build_sbvh(triangles, {});
    const std::int64_t before = areas(tree);
    const std::size_t references = tree.references.size();
    optimize_by_reinsertion(tree, {});
    EXPECT_LE(areas(tree), before);
    EXPECT_EQ(tree.references.size(), references);
    if (count >= 40) {
      EXPECT_LT(areas(tree), before);
    }
  }
}

TEST(WideBvh, ClustersHoldNoMoreTrianglesThanAHitCanNumber) {
  // A fan over few vertices: only the number of triangles can end a cluster.
  ZoneMesh fan;
  for (std::uint16_t i = 0; i < 60; ++i)
    fan.vertices.push_back({static_cast<std::uint16_t>(i * 100), static_cast<std::uint16_t>(i * i), 0});
  for (std::uint32_t a = 0; a < 60; ++a)
    for (std::uint32_t b = a + 1; b + 1 < 60; ++b) fan.triangles.push_back({a, b, b + 1});
  fan.materials.resize(fan.triangles.size());
  NodeRecord record;
  record.triangle_count = static_cast<std::uint32_t>(fan.triangles.size());
  const auto tree = build_wide_bvh(bvh_triangles(fan), {});
  ASSERT_TRUE(tree.ok());
  const BvhFile bvh = lay_out_bvh(*tree, fan, {}, record);
  ASSERT_GT(bvh.clusters.size(), 2U);
  for (std::size_t c = 0; c < bvh.clusters.size(); ++c) {
    const std::size_t end = c + 1 < bvh.clusters.size() ? bvh.clusters[c + 1] : bvh.order.size();
    EXPECT_LE(end - bvh.clusters[c], gpu::kClusterMaxTriangles);
  }
}

}  // namespace
}  // namespace zc
