// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "baker/distance/hausdorff_bound.h"
#include "baker/distance/measure.h"
#include "baker/proxy/components.h"
#include "baker/proxy/decimate.h"
#include "baker/proxy/simplify.h"
#include "baker/proxy/vertex_collapse.h"
#include "baker/repair/manifold_fans.h"
#include "tests/unit/baker/stages.h"
#include "tests/unit/baker/test_city.h"

namespace zc {
namespace {

using test::SceneMaker;

LatticeMesh mesh_of(Scene scene) { return test::snapped(std::move(scene)).mesh; }

std::vector<bool> unlocked(const LatticeMesh& mesh) { return std::vector<bool>(mesh.vertices.size(), false); }

LatticeMesh flat_grid(int cells, bool striped) {
  SceneMaker maker;
  for (int y = 0; y < cells; ++y)
    for (int x = 0; x < cells; ++x)
      maker.quad({x, y, 0}, {x + 1, y, 0}, {x + 1, y + 1, 0}, {x, y + 1, 0}, striped && x < cells / 2 ? 3 : 2);
  maker.object(ObjectKind::kGround);
  return mesh_of(std::move(maker.scene));
}

TEST(Decimate, AFlatGridBecomesTwoTriangles) {
  const LatticeMesh grid = flat_grid(20, false);
  const LatticeMesh out = decimate(grid, unlocked(grid), {1.0, 0, 45, true});
  EXPECT_EQ(out.faces.size(), 2U);
}

TEST(Decimate, MaterialBordersStayUntilAskedToGo) {
  const LatticeMesh grid = flat_grid(20, true);
  const LatticeMesh kept = decimate(grid, unlocked(grid), {1.0, 0, 45, true});
  EXPECT_EQ(kept.faces.size(), 4U);
  double road = 0;
  for (const auto& face : kept.faces) road += face.material == 3 ? face_area(kept, face) : 0;
  EXPECT_DOUBLE_EQ(road, 20.0 * 10 * 256 * 256);
  EXPECT_EQ(decimate(grid, unlocked(grid), {1.0, 0, 45, false}).faces.size(), 2U);
}

TEST(Decimate, LockedVerticesStay) {
  const LatticeMesh grid = flat_grid(20, false);
  std::vector<bool> locked(grid.vertices.size());
  std::set<LatticePoint> border;
  for (std::size_t i = 0; i < locked.size(); ++i) {
    locked[i] = grid.vertices[i][0] == 0;
    if (locked[i]) border.insert(grid.vertices[i]);
  }
  const LatticeMesh out = decimate(grid, locked, {1.0, 0, 45, true});
  for (const auto& p : out.vertices) border.erase(p);
  EXPECT_TRUE(border.empty());
  EXPECT_LT(out.faces.size(), 30U);
}

TEST(Decimate, NonManifoldSoupLosesNothing) {
  SceneMaker maker;
  for (int i = 0; i < 6; ++i)  // six pages on one spine
    maker.triangle({0, 0, 0}, {0, 0, 5}, {std::cos(i) * 4, std::sin(i) * 4, 2}, 0);
  maker.triangle({0, 0, 0}, {4, 0, 0}, {0, 0, 5}, 1);
  maker.object(ObjectKind::kObject);
  const LatticeMesh soup = mesh_of(std::move(maker.scene));
  const LatticeMesh out = decimate(soup, unlocked(soup), {1.0, 0, 45, true});
  EXPECT_EQ(out.faces.size(), soup.faces.size());
  const ManifoldFans fans = split_into_fans(soup);
  EXPECT_GT(fans.source_vertex.size(), soup.vertices.size());
}

TEST(Decimate, WideFansAreCutIntoSectorsAndDoNotGape) {
  SceneMaker maker;
  constexpr int kFaces = 1000;
  const auto at = [](int i) {
    return glm::dvec3(std::cos(i * 2 * M_PI / kFaces) * 90, std::sin(i * 2 * M_PI / kFaces) * 90, i % 8);
  };
  for (int i = 0; i < kFaces; ++i) maker.triangle({0, 0, 9}, at(i), at(i + 1), 0);
  maker.object(ObjectKind::kObject);
  const LatticeMesh fan = mesh_of(std::move(maker.scene));
  LatticeMesh cut = fan;
  std::vector<bool> locked = unlocked(fan);
  cut_wide_fans(cut, 100, locked);
  ASSERT_EQ(cut.faces.size(), fan.faces.size());
  ASSERT_EQ(locked.size(), cut.vertices.size());
  std::map<std::uint32_t, std::size_t> around;
  std::map<std::uint32_t, std::set<std::uint32_t>> hubs;  // by vertex of the rim
  const LatticePoint hub = *std::ranges::max_element(fan.vertices, {}, [](const LatticePoint& p) { return p[2]; });
  for (std::size_t f = 0; f < cut.faces.size(); ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = cut.faces[f].v[k];
      EXPECT_EQ(cut.vertices[v], fan.vertices[fan.faces[f].v[k]]);
      ++around[v];
      for (const std::uint32_t w : cut.faces[f].v)
        if (cut.vertices[w] == hub && w != v) hubs[v].insert(w);
    }
  }
  for (const auto& [v, faces] : around) EXPECT_LE(faces, 100U);
  std::size_t seams = 0;
  for (const auto& [v, sides] : hubs) {
    EXPECT_EQ(locked[v], sides.size() > 1);
    seams += sides.size() > 1 ? 1 : 0;
  }
  EXPECT_EQ(seams, 10U);
  for (std::uint32_t v = 0; v < cut.vertices.size(); ++v) EXPECT_TRUE(cut.vertices[v] != hub || locked[v]);
}

constexpr std::array<std::uint16_t, 4> kAppearances = {0, 1, 2, 3};  // of SceneMaker's materials: all different

// Farthest that a point of `a` is from `b`, from a dense grid on every triangle and every pair of triangles.
double farthest_by_brute_force(const LatticeMesh& a, const LatticeMesh& b) {
  constexpr int kGrid = 24;
  double farthest = 0;
  for (const auto& face : a.faces) {
    const Corners c = corners_of(a, face);
    for (int i = 0; i <= kGrid; ++i) {
      for (int j = 0; i + j <= kGrid; ++j) {
        const glm::dvec3 p = c[0] + (c[1] - c[0]) * (double(i) / kGrid) + (c[2] - c[0]) * (double(j) / kGrid);
        double nearest = INFINITY;
        for (const auto& other : b.faces) {
          const Corners d = corners_of(b, other);
          nearest = std::min(nearest, DistanceTriangle{d[0], d[1] - d[0], d[2] - d[0], {}, 0, 0}.distance(p));
        }
        farthest = std::max(farthest, nearest);
      }
    }
  }
  return farthest;
}

// A wall of 8 × 6 m in the plane y = 1 with a window of 2 × 2 m set back by `depth`.
LatticeMesh wall_with_window(double depth) {
  SceneMaker maker;
  const auto at = [](double x, double z) { return glm::dvec3(x, 1, z); };
  const auto in = [&](double x, double z) { return glm::dvec3(x, 1 + depth, z); };
  constexpr std::array<double, 4> kX = {0, 3, 5, 8};
  constexpr std::array<double, 4> kZ = {0, 2, 4, 6};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      if (i != 1 || j != 1)
        maker.quad(at(kX[i], kZ[j]), at(kX[i + 1], kZ[j]), at(kX[i + 1], kZ[j + 1]), at(kX[i], kZ[j + 1]), 0);
  maker.quad(at(3, 2), in(3, 2), in(3, 4), at(3, 4), 0);
  maker.quad(at(5, 2), in(5, 2), in(5, 4), at(5, 4), 0);
  maker.quad(at(3, 2), at(5, 2), in(5, 2), in(3, 2), 0);
  maker.quad(at(3, 4), at(5, 4), in(5, 4), in(3, 4), 0);
  maker.quad(in(3, 2), in(5, 2), in(5, 4), in(3, 4), 3);
  maker.object(ObjectKind::kObject);
  return mesh_of(std::move(maker.scene));
}

TEST(VertexCollapse, AFlatGridBecomesTwoTriangles) {
  const LatticeMesh grid = flat_grid(20, false);
  EXPECT_EQ(collapse_vertices(grid, unlocked(grid), kAppearances, {2.0, 2, 0}).mesh.faces.size(), 2U);
}

TEST(VertexCollapse, BordersBetweenAppearancesStayUntilAppearancesAreTheSame) {
  const LatticeMesh grid = flat_grid(20, true);
  const LatticeMesh kept = collapse_vertices(grid, unlocked(grid), kAppearances, {2.0, 2, 0}).mesh;
  EXPECT_EQ(kept.faces.size(), 4U);
  double road = 0;
  for (const auto& face : kept.faces) road += face.material == 3 ? face_area(kept, face) : 0;
  EXPECT_DOUBLE_EQ(road, 20.0 * 10 * 256 * 256);
  const std::array<std::uint16_t, 4> same = {};
  EXPECT_EQ(collapse_vertices(grid, unlocked(grid), same, {2.0, 2, 0}).mesh.faces.size(), 2U);
}

// A floor of one row of tiles, whose neighbours are 64 classes apart: no set of 64 bits separates all of them.
TEST(VertexCollapse, MoreThan64AppearancesKeepTheirPlaces) {
  constexpr int kColours = 160;
  SceneMaker maker;
  maker.scene.materials.clear();
  for (int i = 0; i < kColours; ++i)
    maker.scene.materials.push_back({"", {0.09F * static_cast<float>(i % 10), 0.09F * static_cast<float>(i / 10), 0}});
  const std::vector<std::uint16_t> appearances = appearance_classes(maker.scene.materials);
  ASSERT_EQ(*std::ranges::max_element(appearances), kColours - 1);
  const auto colour = [](int tile) { return static_cast<std::uint16_t>(tile / 2 + (tile % 2) * 64); };
  constexpr int kTiles = 128;
  for (int tile = 0; tile < kTiles; ++tile)
    for (int x = 4 * tile; x < 4 * tile + 4; ++x)
      maker.quad({x, 0, 0}, {x + 1, 0, 0}, {x + 1, 4, 0}, {x, 4, 0}, colour(tile));
  maker.object(ObjectKind::kObject);
  const LatticeMesh floor = mesh_of(std::move(maker.scene));
  const LatticeMesh out = collapse_vertices(floor, unlocked(floor), appearances, {25.6, 2, 0}).mesh;
  EXPECT_EQ(out.faces.size(), 2U * kTiles);
  std::map<std::uint16_t, double> area;
  for (const auto& face : out.faces) area[face.material] += face_area(out, face);
  EXPECT_EQ(area.size(), std::size_t{kTiles});
  for (const auto& [material, sum] : area) EXPECT_DOUBLE_EQ(sum, 16.0 * 256 * 256) << material;
}

TEST(Measure, TheNearestOfAnAppearanceIsOfNoOther) {
  SceneMaker maker;
  maker.quad({0, 0, 0}, {8, 0, 0}, {8, 8, 0}, {0, 8, 0}, 0);
  maker.quad({0, 0, 1}, {8, 0, 1}, {8, 8, 1}, {0, 8, 1}, 1);
  maker.quad({0, 0, 2}, {8, 0, 2}, {8, 8, 2}, {0, 8, 2}, 2);
  maker.object(ObjectKind::kObject);
  const LatticeMesh mesh = mesh_of(std::move(maker.scene));
  const std::array<std::uint16_t, 4> appearances = {7, 71, 135, 0};
  const DistanceBvh bvh(mesh, appearances);
  for (std::size_t m = 0; m < 3; ++m) {
    const DistanceTriangle* found = nullptr;
    double distance = INFINITY;
    bvh.nearest({500, 500, 0}, appearances[m], 0, found, distance);
    ASSERT_NE(found, nullptr);
    EXPECT_EQ(found->appearance, appearances[m]);
    EXPECT_EQ(distance, 256.0 * static_cast<double>(m));
    EXPECT_TRUE(bvh.may_have(appearances[m]));
  }
  const AppearanceSet near = bvh.appearances_within({500, 500, 0}, 300, appearances[0]);
  EXPECT_TRUE(near.has(7));
  EXPECT_TRUE(near.has(71));
  EXPECT_FALSE(near.has(135));
}

TEST(VertexCollapse, LockedVerticesAndTheEdgesBetweenThemStay) {
  const LatticeMesh grid = flat_grid(20, false);
  std::vector<bool> locked(grid.vertices.size());
  std::set<LatticePoint> border;
  for (std::size_t i = 0; i < locked.size(); ++i) {
    locked[i] = grid.vertices[i][0] == 0;
    if (locked[i]) border.insert(grid.vertices[i]);
  }
  const LatticeMesh out = collapse_vertices(grid, locked, kAppearances, {25.6, 45, 0}).mesh;
  std::size_t edges = 0;
  for (const auto& face : out.faces)
    for (std::size_t i = 0; i < 3; ++i)
      edges += out.vertices[face.v[i]][0] == 0 && out.vertices[face.v[(i + 1) % 3]][0] == 0 ? 1 : 0;
  EXPECT_EQ(edges, 20U);
  for (const auto& p : out.vertices) border.erase(p);
  EXPECT_TRUE(border.empty());
  EXPECT_LT(out.faces.size(), 30U);
}

TEST(VertexCollapse, AShallowRevealGoesADeepOneStays) {
  const LatticeMesh shallow = wall_with_window(0.03);
  const LatticeMesh flat = collapse_vertices(shallow, unlocked(shallow), kAppearances, {25.6, 2, 0}).mesh;
  EXPECT_LE(flat.faces.size(), 10U);  // eight around the window, two in it
  for (const auto& p : flat.vertices) EXPECT_EQ(p[1], flat.vertices[0][1]);
  double glass = 0;
  for (const auto& face : flat.faces) glass += face.material == 3 ? face_area(flat, face) : 0;
  EXPECT_DOUBLE_EQ(glass, 4.0 * 256 * 256);

  const LatticeMesh deep = wall_with_window(0.5);
  const LatticeMesh kept = collapse_vertices(deep, unlocked(deep), kAppearances, {25.6, 2, 0}).mesh;
  EXPECT_EQ(kept.faces.size(), 8U + 8U + 2U);
}

TEST(VertexCollapse, APoleOfManySidesStaysClosed) {
  constexpr int kSides = 16;
  SceneMaker maker;
  const auto at = [](int i, double z) {
    const double angle = 2 * M_PI * i / kSides;
    return glm::dvec3(5 + 0.04 * std::cos(angle), 5 + 0.04 * std::sin(angle), z);
  };
  for (int i = 0; i < kSides; ++i) {
    maker.quad(at(i, 0), at(i + 1, 0), at(i + 1, 4), at(i, 4), 0);
    maker.triangle({5, 5, 0}, at(i + 1, 0), at(i, 0), 0);
    maker.triangle({5, 5, 4}, at(i, 4), at(i + 1, 4), 0);
  }
  maker.object(ObjectKind::kObject);
  const LatticeMesh pole = mesh_of(std::move(maker.scene));
  const LatticeMesh out = collapse_vertices(pole, unlocked(pole), kAppearances, {25.6, 2, 0}).mesh;
  EXPECT_LE(out.faces.size(), 12U);
  EXPECT_GE(out.faces.size(), 4U);
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& face : out.faces)
    for (std::size_t i = 0; i < 3; ++i) ++edges[std::minmax(face.v[i], face.v[(i + 1) % 3])];
  for (const auto& [edge, faces] : edges) EXPECT_EQ(faces, 2);
}

TEST(VertexCollapse, TheResultIsWithinTheToleranceBothWays) {
  SceneMaker maker;
  maker.terrain({0, 0, 0}, 12, 1.3);
  maker.houses({0, 0, 0}, 2, 7.1);
  for (int i = 0; i < 40; ++i) {  // soup: slivers, pages on one spine, overlaps
    const double x = (i * 7) % 13;
    const double y = (i * 5) % 11;
    maker.triangle({x, y, 2}, {x + 1 + 0.1 * i, y + 0.02 * i, 2.1}, {x + 0.3, y + 1, 2 + 0.01 * (i % 9)},
                   static_cast<std::uint16_t>(i % 2));
  }
  maker.object(ObjectKind::kObject);
  const LatticeMesh mesh = mesh_of(std::move(maker.scene));
  for (const double tolerance : {5.0, 25.6, 128.0}) {
    const LatticeMesh out = collapse_vertices(mesh, unlocked(mesh), kAppearances, {tolerance, 10, 0}).mesh;
    EXPECT_LT(out.faces.size(), mesh.faces.size());
    EXPECT_LE(farthest_by_brute_force(out, mesh), tolerance);
    EXPECT_LE(farthest_by_brute_force(mesh, out), tolerance);
  }
}

TEST(TriangleCover, TheBoundHoldsAndIsTight) {
  SceneMaker maker;
  maker.terrain({0, 0, 0}, 6, 1.7);
  const LatticeMesh terrain = mesh_of(std::move(maker.scene));
  const DistanceBvh bvh(terrain);
  const auto nearest = [&](const glm::dvec3& p, double& distance) {
    const DistanceTriangle* found = nullptr;
    bvh.nearest(p, std::nullopt, 0, found, distance);
    return found;
  };
  LatticeMesh one;
  one.vertices = {{0, 0, 600}, {2600, 100, 500}, {300, 2600, 900}};
  one.faces = {{{0, 1, 2}, 0, false}};
  const double measured = farthest_by_brute_force(one, terrain);
  const HausdorffBound found =
      hausdorff_bound(corners_of(one, one.faces[0]), {measured, 0, 1, 1000000, false}, nearest);
  EXPECT_GE(found.bound, measured);
  EXPECT_LE(found.bound, measured * 1.05);
  EXPECT_TRUE(hausdorff_bound(corners_of(one, one.faces[0]), {measured * 1.05, 0, 1, 1000000, false}, nearest).within);
  EXPECT_FALSE(hausdorff_bound(corners_of(one, one.faces[0]), {measured * 0.95, 0, 1, 1000000, true}, nearest).within);
}

TEST(Measure, AKnownOffsetIsFoundBothWays) {
  SceneMaker low, high;
  low.quad({0, 0, 0}, {8, 0, 0}, {8, 8, 0}, {0, 8, 0}, 0);
  low.quad({0, 0, 0.5}, {8, 0, 0.5}, {8, 8, 0.5}, {0, 8, 0.5}, 0);
  low.object(ObjectKind::kObject);
  high.quad({0, 0, 0}, {8, 0, 0}, {8, 8, 0}, {0, 8, 0}, 1);
  high.object(ObjectKind::kObject);
  const LatticeMesh detail = mesh_of(std::move(low.scene));
  const LatticeMesh proxy = mesh_of(std::move(high.scene));
  const DistanceBvh bvh(detail);
  const DetailSurface surface = {&detail, &bvh};
  const std::vector<Material> materials = {{"a", {0, 0, 0}}, {"b", {0.5F, 0.5F, 0.5F}}};
  const SurfaceError error =
      measure_proxy(proxy, std::span(&surface, 1), materials, appearance_classes(materials), 1.0 / 256);
  EXPECT_DOUBLE_EQ(error.max_m, 0.5);  // only the detail's upper sheet sees it
  EXPECT_NEAR(error.mean_m, 0.125, 1e-3);
  EXPECT_NEAR(error.color_error, 0.5, 1e-6);
  EXPECT_NEAR(error.normal_deviation_deg, 0, 1e-3);
}

TEST(Measure, AnAppearanceThatIsNowhereLeavesDistancesCloseOnManySurfaces) {
  constexpr std::int32_t kSide = 50;    // surfaces along a side
  constexpr std::int32_t kSteps = 256;  // of a surface
  const auto quad = [](LatticePoint at, std::int32_t size, std::uint16_t material) {
    const auto [x, y, z] = at;
    return LatticeMesh{{{x, y, z}, {x + size, y, z}, {x + size, y + size, z}, {x, y + size, z}},
                       {{{0, 1, 2}, material}, {{0, 2, 3}, material}}};
  };
  const std::vector<Material> materials = {{"a", {0, 0, 0}}, {"b", {0.5F, 0.5F, 0.5F}}};
  const std::vector<std::uint16_t> appearances = appearance_classes(materials);
  std::vector<LatticeMesh> meshes;
  std::vector<DistanceBvh> trees;
  std::vector<DetailSurface> surfaces;
  for (std::int32_t i = 0; i < kSide * kSide; ++i) {
    meshes.push_back(quad({i % kSide * kSteps, i / kSide * kSteps, 0}, kSteps, 0));
    trees.emplace_back(meshes.back(), appearances);
  }
  for (std::size_t i = 0; i < meshes.size(); ++i) surfaces.push_back({&meshes[i], &trees[i]});
  const LatticeMesh proxy = quad({0, 0, kSteps}, kSide * kSteps, 1);
  const SurfaceError error = measure_proxy(proxy, surfaces, materials, appearances, 1.0 / kSteps);
  EXPECT_FALSE(error.is_loose);
  EXPECT_GE(error.max_m, 1);
  EXPECT_LT(error.max_m, 2);  // a bound
  EXPECT_NEAR(error.mean_m, 1, 1e-6);
  EXPECT_NEAR(error.appearance_m, 1, 1e-6);  // where there is nothing of its appearance: to the other surface
}

TEST(Measure, ClosestPointsAgreeWithEveryTriangleTried) {
  SceneMaker maker;
  maker.terrain({0, 0, 0}, 12, 3.3);
  const LatticeMesh mesh = mesh_of(std::move(maker.scene));
  const DistanceBvh bvh(mesh);
  for (int i = 0; i < 200; ++i) {
    const glm::dvec3 p((i * 977) % 12000 - 1000, (i * 613) % 12000 - 1000, (i * 331) % 4000 - 1000);
    double expected = INFINITY;
    for (const auto& face : mesh.faces) {
      LatticeMesh one;
      one.vertices = {mesh.vertices[face.v[0]], mesh.vertices[face.v[1]], mesh.vertices[face.v[2]]};
      one.faces = {{{0, 1, 2}, 0, false}};
      ClosestHit hit;
      hit.distance = INFINITY;
      DistanceBvh(one).closest(p, {0, 0, 1}, 0, hit);
      expected = std::min(expected, hit.distance);
    }
    ClosestHit hit;
    hit.distance = INFINITY;
    bvh.closest(p, {0, 0, 1}, 0, hit);
    ASSERT_DOUBLE_EQ(hit.distance, expected);
  }
}

TEST(Components, SmallPartsGoButNeverTheGround) {
  SceneMaker maker;
  maker.terrain({0, 0, 0}, 4, 0.5);
  maker.houses({50, 50, 0}, 3, 20);
  maker.box({64, 64, 0}, {64.5, 64.5, 0.5});  // between houses: goes
  maker.object(ObjectKind::kObject);
  maker.box({500, 0, 0}, {500.5, 0.5, 0.5});  // alone: stays
  maker.object(ObjectKind::kObject);
  LatticeMesh mesh = mesh_of(std::move(maker.scene));
  const std::size_t before = mesh.faces.size();
  drop_small_components(mesh, 5 * 256, 0);
  EXPECT_EQ(mesh.faces.size(), before - 10);
  drop_components_to(mesh, 0);
  for (const auto& face : mesh.faces) EXPECT_TRUE(face.ground);
  EXPECT_EQ(mesh.faces.size(), 32U);
}

TEST(Components, WhatIsLostFarFromAllElseGetsAStandIn) {
  SceneMaker maker;
  maker.quad({-10, 0, 0}, {0, 0, 0}, {0, 10, 0}, {-10, 10, 0}, 2);
  maker.quad({300, 0, 0}, {303, 0, 0}, {303, 200, 0}, {300, 200, 0}, 3);
  maker.object(ObjectKind::kGround);
  for (const double x : {10.0, 500.0, 900.0, 905.0}) {
    maker.box({x, 0, 0}, {x + 4, 4, 3});
    maker.object(ObjectKind::kObject);
  }
  const LatticeMesh source = mesh_of(std::move(maker.scene));
  LatticeMesh left = source;  // the first ground and nothing else
  std::erase_if(left.faces, [](const LatticeFace& face) { return !face.ground || face.material == 3; });
  weld(left);
  const auto farthest_m = [&](const LatticeMesh& mesh) {
    const DistanceBvh bvh(mesh);
    double farthest = 0;
    for (const LatticePoint& p : source.vertices)
      farthest = std::max(farthest, bvh.closest_of_appearance({p[0], p[1], p[2]}, 0, 1e9));
    return farthest / 256;
  };
  EXPECT_GT(farthest_m(left), 900);

  LatticeMesh mesh = left;
  add_stand_ins(source, 30 * 256, 100, mesh);
  EXPECT_LT(farthest_m(mesh), 100);  // of the street, half of which one triangle is
  std::map<std::array<std::uint32_t, 2>, int> edges;
  std::size_t bodies = 0;
  for (std::size_t f = left.faces.size(); f < mesh.faces.size(); ++f) {
    const LatticeFace& face = mesh.faces[f];
    if (face.ground) continue;
    ++bodies;
    for (std::size_t i = 0; i < 3; ++i) ++edges[{face.v[i], face.v[(i + 1) % 3]}];
  }
  EXPECT_EQ(bodies, 8U);  // two: the near box is within 30 m, and the last two share one
  for (const auto& [edge, count] : edges) EXPECT_EQ(count, (edges.contains({edge[1], edge[0]}) ? 1 : 0));

  mesh = left;
  add_stand_ins(source, 30 * 256, 4, mesh);  // enough for one, and the farthest is first
  EXPECT_EQ(mesh.faces.size(), left.faces.size() + 4);
  EXPECT_LT(farthest_m(mesh), 410);
  mesh = left;
  add_stand_ins(source, 1000 * 256, 100, mesh);
  EXPECT_EQ(mesh, left);
}

TEST(Simplify, ALeafKeepsItsErrorBound) {
  const SnappedScene scene = test::snapped(test::small_city());
  const ZoneTree tree = test::cut(scene, 1000000).tree;
  ASSERT_EQ(tree.zones.size(), 1U);
  const LatticeMesh& detail = tree.zones[0].detail;
  const DistanceBvh bvh(detail);
  const std::vector<std::uint16_t> appearances = appearance_classes(scene.materials);
  for (const double error_m : {0.02, 0.2, 1.0}) {
    const SimplifyContext context = {&tree.grid, scene.materials, appearances, 1.0 / 256, error_m, 1000000};
    const Proxy proxy = simplify_leaf(context, tree.zones[0], round_detail(detail), {&detail, &bvh});
    EXPECT_LE(proxy.error.max_m, error_m);
    EXPECT_LE(proxy.mesh.faces.size(), detail.faces.size());
  }
}

TEST(Simplify, TheRootReachesItsTargetWhateverItTakes) {
  SceneMaker maker;
  for (int i = 0; i < 3000; ++i) {  // loose ground triangles: nothing to collapse, nothing to drop
    const double x = (i % 60) * 5.0;
    const double y = (i / 60) * 5.0;
    maker.triangle({x, y, i % 7}, {x + 3, y, i % 5}, {x, y + 3, i % 3}, 2);
  }
  maker.object(ObjectKind::kGround);
  const SnappedScene scene = test::snapped(std::move(maker.scene));
  const ZoneTree tree = test::cut(scene, 1000000).tree;
  const LatticeMesh& detail = tree.zones[0].detail;
  const DistanceBvh bvh(detail);
  const std::vector<std::uint16_t> appearances = appearance_classes(scene.materials);
  const SimplifyContext context = {&tree.grid, scene.materials, appearances, 1.0 / 256, 0.05, 400};
  const Proxy proxy = simplify_leaf(context, tree.zones[0], round_detail(detail), {&detail, &bvh});
  EXPECT_LE(proxy.mesh.faces.size(), 400U);
  EXPECT_GT(proxy.mesh.faces.size(), 0U);
  EXPECT_GT(proxy.error.max_m, 0.05);
}

}  // namespace
}  // namespace zc
