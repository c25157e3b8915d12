// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/cut/cut.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <span>

#include "tests/unit/baker/stages.h"
#include "tests/unit/baker/test_city.h"

namespace zc {
namespace {

using test::SceneMaker;
using test::snapped;

double plan_area(const LatticeMesh& mesh) {  // of upward faces, seen from above
  double area = 0;
  for (const auto& face : mesh.faces) {
    const auto& a = mesh.vertices[face.v[0]];
    const auto& b = mesh.vertices[face.v[1]];
    const auto& c = mesh.vertices[face.v[2]];
    area += 0.5 * ((double(b[0]) - a[0]) * (double(c[1]) - a[1]) - (double(c[0]) - a[0]) * (double(b[1]) - a[1]));
  }
  return area;
}

TEST(Cut, TheGroundIsCoveredExactlyOnce) {
  SceneMaker maker;
  maker.terrain({0, 0, 0}, 64, 7.3);
  const SnappedScene scene = snapped(std::move(maker.scene));
  const double before = plan_area(scene.mesh);
  const ZoneTree tree = test::cut(scene, 300).tree;
  double after = 0;
  std::size_t leaves = 0;
  for (const auto& zone : tree.zones) {
    after += plan_area(zone.detail);
    leaves += zone.children.empty() ? 1 : 0;
  }
  EXPECT_GT(leaves, 16U);
  // Only the outer rim may move, by less than a step of the coarsest border.
  EXPECT_NEAR(after / before, 1.0, 1e-5);
}

TEST(Cut, BothSidesOfEveryBorderHaveTheSameVertices) {
  SceneMaker maker;
  maker.terrain({0, 0, 0}, 64, 7.3);
  maker.terrain({100.3, 100.7, 40}, 90, 1.1);  // denser: neighbours of different depth
  const SnappedScene scene = snapped(std::move(maker.scene));
  const ZoneTree tree = test::cut(scene, 300).tree;
  // Edges on border planes, from all zones: each must have its reverse, or lie on the rim of the scene.
  std::map<std::pair<LatticePoint, LatticePoint>, int> edges;
  std::set<std::uint32_t> depths;
  for (const auto& zone : tree.zones) {
    if (zone.children.empty()) depths.insert(zone.depth);
    for (const auto& face : zone.detail.faces) {
      for (std::size_t i = 0; i < 3; ++i) {
        const LatticePoint a = zone.detail.vertices[face.v[i]];
        const LatticePoint b = zone.detail.vertices[face.v[(i + 1) % 3]];
        for (std::size_t axis = 0; axis < 2; ++axis) {
          if (a[axis] != b[axis]) continue;
          if (tree.grid.on_cell_border(zone, a) && tree.grid.on_cell_border(zone, b)) {
            ++edges[{a, b}];
            --edges[{b, a}];
          }
        }
      }
    }
  }
  EXPECT_GT(depths.size(), 1U);
  EXPECT_GT(edges.size(), 200U);
  std::size_t unmet = 0;
  for (const auto& [edge, count] : edges) unmet += count != 0 ? 1 : 0;
  EXPECT_EQ(unmet, 0U);
}

TEST(Cut, BorderVerticesSurviveTheStepOfEveryNodeThatMeetsThere) {
  SceneMaker maker;
  maker.terrain({0, 0, 0}, 80, 41.7);
  const SnappedScene scene = snapped(std::move(maker.scene));
  const ZoneTree tree = test::cut(scene, 300).tree;
  std::size_t checked = 0;
  for (const auto& leaf : tree.zones) {
    for (const auto& p : leaf.detail.vertices) {
      for (const Zone* zone = &leaf;; zone = &tree.zones[static_cast<std::size_t>(zone->parent)]) {
        if (tree.grid.on_cell_border(*zone, p)) {
          const std::uint32_t shift = tree.grid.step_shift_bound(zone->depth);
          for (const std::int32_t c : p) ASSERT_EQ(round_to_step(c, shift), c);
          ++checked;
        }
        if (zone->parent < 0) break;
      }
    }
  }
  EXPECT_GT(checked, 100U);
}

TEST(Cut, ObjectsStayWholeInTheZoneOfTheirCentre) {
  const SnappedScene scene = snapped(test::small_city());
  const std::size_t boxes = scene.objects.size() - 1;
  const ZoneTree tree = test::cut(scene, 500).tree;
  std::size_t object_faces = 0;
  for (const auto& zone : tree.zones) {
    std::size_t own = 0;
    for (const auto& face : zone.detail.faces) own += face.ground ? 0 : 1;
    EXPECT_EQ(own % 10, 0U);
    object_faces += own;
  }
  EXPECT_EQ(object_faces, boxes * 10);
}

TEST(Cut, AHugeObjectIsCutAndSaysSo) {
  SceneMaker maker;
  maker.box({0, 0, 0}, {400, 30, 20});
  maker.object(ObjectKind::kObject);
  maker.houses({0, 100, 0}, 30, 14);
  const SnappedScene scene = snapped(std::move(maker.scene));
  const CutScene out = test::cut(scene, 200);
  ASSERT_FALSE(out.notes.empty());
  EXPECT_EQ(out.notes.back().what, "objects wider than 128 m, cut at zone borders");
  EXPECT_GT(out.tree.zones.size(), 4U);
}

TEST(Cut, EverythingInOnePlaceEndsInOneSmallCell) {
  SceneMaker maker;
  for (int i = 0; i < 1000; ++i) maker.triangle({0, 0, 0}, {1, i * 0.01, 0}, {0, 0, 1}, 0);
  maker.object(ObjectKind::kGround);
  const SnappedScene scene = snapped(std::move(maker.scene));
  const ZoneTree tree = test::cut(scene, 100).tree;
  EXPECT_EQ(tree.zones.size(), 1U);
  EXPECT_EQ(tree.zones[0].detail.faces.size(), scene.mesh.faces.size());
}

TEST(Cut, WhatLiesOverEachOtherIsNotMultiplied) {
  SceneMaker maker;  // sheets as wide as the world, at other heights
  for (int i = 0; i < 500; ++i) maker.triangle({0, 0, i * 0.1}, {200, i * 0.1, i * 0.1}, {i * 0.1, 200, i * 0.1}, 0);
  maker.object(ObjectKind::kObject);
  const SnappedScene scene = snapped(std::move(maker.scene));
  const ZoneTree tree = test::cut(scene, 100).tree;
  std::size_t faces = 0;
  for (const auto& zone : tree.zones) faces += zone.detail.faces.size();
  EXPECT_EQ(faces, scene.mesh.faces.size());
}

// Houses far from each other on two large triangles of ground: zones are split until their steps are fine, however few
// triangles they hold.
// A fan to one vertex 1,000 km away, beside a row of houses: its triangles lie side by side however small the cells
// are.
TEST(Cut, AFanToOneFarVertexIsNotChopped) {
  SceneMaker maker;
  constexpr int kFan = 200;
  for (int i = 0; i < kFan; ++i)
    maker.triangle({i * 0.1, 0, 0}, {(i + 1) * 0.1, 0, 0}, {30, 1e6, 0}, static_cast<std::uint16_t>(2 + i % 2));
  maker.object(ObjectKind::kGround);
  for (int i = 0; i < 50; ++i) {
    maker.box({20.0 * i, 0, 0}, {20.0 * i + 10, 10, 8});
    maker.object(ObjectKind::kObject);
  }
  const CutScene scene = test::cut(snapped(std::move(maker.scene)), 64);
  std::size_t faces = 0;
  std::size_t leaves = 0;
  for (const Zone& zone : scene.tree.zones) {
    faces += zone.detail.faces.size();
    leaves += zone.children.empty() ? 1 : 0;
  }
  EXPECT_GT(leaves, 16U);  // the houses have zones of their own all the same
  EXPECT_LT(leaves, 400U);
  EXPECT_LT(faces, 100'000U);
}

TEST(Cut, ZonesOfFewTrianglesAreSplitUntilTheirStepIsFine) {
  SceneMaker maker;
  maker.triangle({0, 0, 0}, {9000, 0, 5}, {9000, 9000, 0}, 0);
  maker.triangle({0, 0, 0}, {9000, 9000, 0}, {0, 9000, 5}, 0);
  maker.object(ObjectKind::kGround);
  for (int i = 0; i < 30; ++i) {
    const double x = 100.0 + 290 * i;
    maker.triangle({x, x, 0}, {x + 10, x, 0}, {x, x, 10}, 1);
    maker.object(ObjectKind::kObject);
  }
  const SnappedScene scene = snapped(std::move(maker.scene));
  EXPECT_EQ(leaf_step_shift(0.1, 1.0 / 256), 4U);
  EXPECT_EQ(leaf_step_shift(0.001, 1.0 / 256), 0U);
  EXPECT_EQ(test::cut(scene, 4000).tree.zones.size(), 1U);
  const ZoneTree tree = test::cut(scene, 4000, 3).tree;
  std::size_t houses = 0;
  for (const Zone& zone : tree.zones) {
    if (!zone.children.empty()) continue;
    EXPECT_LE(step_shift_for_box(bounds_of(zone.detail)), 3U);
    for (const LatticeFace& face : zone.detail.faces) houses += face.ground ? 0 : 1;
  }
  EXPECT_EQ(houses, 30U);
}

TEST(Cut, ZonesStateHowFarRoundedBordersLieOffTheGround) {
  SceneMaker maker;  // a slope of 40 km, in triangles of 1.3 km
  const auto at = [](int i, int j) {
    return glm::dvec3(1303.7 * i, 1301.3 * j, 0.037 * 1303.7 * i + 0.011 * 1301.3 * j);
  };
  for (int i = 0; i < 31; ++i)
    for (int j = 0; j < 31; ++j) maker.quad(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1), 0);
  maker.object(ObjectKind::kGround);
  const SnappedScene scene = snapped(std::move(maker.scene));
  const double snap = std::sqrt(0.75);
  const ZoneTree tree = test::cut(scene, 10).tree;
  double farthest = 0;
  double least_moved = std::numeric_limits<double>::infinity();
  for (const Zone& zone : tree.zones) {
    if (!zone.children.empty()) continue;
    double off = 0;
    for (const LatticePoint& p : zone.detail.vertices) {
      const glm::dvec3 q(p[0] + scene.lattice.anchor[0], p[1] + scene.lattice.anchor[1],
                         p[2] + scene.lattice.anchor[2]);
      off = std::max(off, std::abs(0.037 * q.x + 0.011 * q.y - q.z) / std::sqrt(1 + 0.037 * 0.037 + 0.011 * 0.011));
    }
    EXPECT_LE(off, zone.moved[1] + snap);
    farthest = std::max(farthest, off);
    least_moved = std::min<double>(least_moved, zone.moved[1]);
  }
  EXPECT_GT(farthest, 20);     // steps: the case is hard
  EXPECT_LT(least_moved, 20);  // and only so where coarse borders are
}

TEST(Cut, APartOfACityIsCutAsTheWholeIs) {
  SceneMaker maker;
  maker.houses({0, 0, 0}, 24, 23.3);
  const SnappedScene city = snapped(std::move(maker.scene));
  const CellGrid grid = fit_cells(city, 100);
  const auto zones_of = [&](const SnappedScene& scene) {
    BakeContext context;
    std::map<std::array<std::uint32_t, 3>, LatticeMesh> zones;
    CutScene out = *cut_zones({scene, 100, 30, grid}, context);
    for (Zone& zone : out.tree.zones)
      if (zone.children.empty()) zones[{zone.depth, zone.cell_x, zone.cell_y}] = std::move(zone.detail);
    return zones;
  };
  SnappedScene part = city;  // the first quarter's objects
  part.objects.clear();
  part.mesh.faces.clear();
  const std::int64_t half = grid.cell_size(1);
  for (SceneObject object : city.objects) {
    LatticeBox box;
    const auto first = city.mesh.faces.begin() + object.first_triangle;
    const std::span faces(first, object.triangle_count);
    for (const LatticeFace& face : faces)
      for (const std::uint32_t v : face.v) box.add(city.mesh.vertices[v]);
    if (box.min[0] + box.max[0] >= 2 * half || box.min[1] + box.max[1] >= 2 * half) continue;
    object.first_triangle = static_cast<std::uint32_t>(part.mesh.faces.size());
    part.mesh.faces.insert(part.mesh.faces.end(), faces.begin(), faces.end());
    part.objects.push_back(object);
  }
  const auto whole = zones_of(city);
  const auto quarter = zones_of(part);
  EXPECT_GT(quarter.size(), 8U);
  EXPECT_LT(quarter.size(), whole.size());
  for (const auto& [cell, detail] : quarter) {
    ASSERT_TRUE(whole.contains(cell));
    EXPECT_EQ(whole.at(cell), detail);
  }
}

}  // namespace
}  // namespace zc
