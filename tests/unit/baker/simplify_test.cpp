// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "baker/components.h"
#include "baker/decimate.h"
#include "baker/manifold_fans.h"
#include "baker/measure.h"
#include "baker/simplify.h"
#include "tests/unit/baker/test_city.h"

namespace zc {
namespace {

using test::SceneMaker;

LatticeMesh mesh_of(Scene scene) {
  auto snapped = snap_scene(std::move(scene), -8);
  EXPECT_TRUE(snapped.ok());
  return std::move(snapped->mesh);
}

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
      measure_proxy(proxy, std::span(&surface, 1), materials, look_classes(materials), 1.0 / 256);
  EXPECT_DOUBLE_EQ(error.max_m, 0.5);  // only the detail's upper sheet sees it
  EXPECT_NEAR(error.mean_m, 0.125, 1e-3);
  EXPECT_NEAR(error.color_error, 0.5, 1e-6);
  EXPECT_NEAR(error.normal_deviation_deg, 0, 1e-3);
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

TEST(Simplify, ALeafKeepsItsErrorBound) {
  SnappedScene scene = *snap_scene(test::small_city(), -8);
  const ZoneTree tree = cut_zones(scene, 1000000);
  ASSERT_EQ(tree.zones.size(), 1U);
  const LatticeMesh& detail = tree.zones[0].detail;
  const DistanceBvh bvh(detail);
  const std::vector<std::uint16_t> looks = look_classes(scene.materials);
  for (const double error_m : {0.02, 0.2, 1.0}) {
    const SimplifyContext context = {&tree.grid, scene.materials, looks, 1.0 / 256, error_m, 1000000};
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
  SnappedScene scene = *snap_scene(std::move(maker.scene), -8);
  const ZoneTree tree = cut_zones(scene, 1000000);
  const LatticeMesh& detail = tree.zones[0].detail;
  const DistanceBvh bvh(detail);
  const std::vector<std::uint16_t> looks = look_classes(scene.materials);
  const SimplifyContext context = {&tree.grid, scene.materials, looks, 1.0 / 256, 0.05, 400};
  const Proxy proxy = simplify_leaf(context, tree.zones[0], round_detail(detail), {&detail, &bvh});
  EXPECT_LE(proxy.mesh.faces.size(), 400U);
  EXPECT_GT(proxy.mesh.faces.size(), 0U);
  EXPECT_GT(proxy.error.max_m, 0.05);
}

}  // namespace
}  // namespace zc
