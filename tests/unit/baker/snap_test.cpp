// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/repair/snap.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/baker/stages.h"
#include "tests/unit/baker/test_city.h"

namespace zc {
namespace {

using test::SceneMaker;
using test::snap;

TEST(Snap, LargeCoordinatesKeepMillimetresRelativeToTheAnchor) {
  SceneMaker maker;
  const glm::dvec3 o(1e7, -1e7, 512.25);
  maker.triangle(o, o + glm::dvec3(1.5, 0, 0), o + glm::dvec3(0, 2.25, 0.5), 0);
  maker.object(ObjectKind::kObject);
  auto snapped = snap(std::move(maker.scene));
  ASSERT_TRUE(snapped.ok());
  EXPECT_EQ(snapped->lattice.anchor[0], 10000000LL * 256);
  EXPECT_EQ(snapped->lattice.anchor[1], -10000000LL * 256);
  EXPECT_EQ(snapped->lattice.anchor[2], 512LL * 256);
  EXPECT_EQ(snapped->mesh.vertices[0], (LatticePoint{0, 0, 64}));
  EXPECT_EQ(snapped->mesh.vertices[1], (LatticePoint{0, 576, 192}));
  EXPECT_EQ(snapped->mesh.vertices[2], (LatticePoint{384, 0, 64}));
}

TEST(Snap, WeldsAndKeepsEveryFace) {
  SceneMaker maker;
  const glm::dvec3 a(0), b(1, 0, 0), c(0, 1, 0);
  maker.triangle(a, b, c, 0);
  maker.triangle(b, c + glm::dvec3(1e-4), a, 1);
  maker.object(ObjectKind::kObject);
  maker.object(ObjectKind::kObject);  // of no triangle
  auto snapped = snap(std::move(maker.scene));
  ASSERT_TRUE(snapped.ok());
  EXPECT_EQ(snapped->mesh.vertices.size(), 3U);
  EXPECT_EQ(snapped->mesh.faces.size(), 2U);
  EXPECT_EQ(snapped->objects.size(), 1U);
}

TEST(Snap, RefusesEmptyBrokenAndTooWideScenes) {
  EXPECT_FALSE(snap(Scene{}).ok());
  SceneMaker wide;
  wide.triangle({0, 0, 0}, {5e6, 0, 0}, {0, 1, 0}, 0);
  wide.object(ObjectKind::kObject);
  EXPECT_FALSE(snap(std::move(wide.scene)).ok());
  SceneMaker broken;
  broken.triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0);
  broken.object(ObjectKind::kObject);
  Scene dangling = broken.scene;
  dangling.triangles[0][1] = 7;
  EXPECT_FALSE(snap(std::move(dangling)).ok());
  EXPECT_FALSE(snap(std::move(broken.scene), 3).ok());
}

TEST(Snap, APartOfACityLiesOnTheLatticeOfTheWhole) {
  SceneMaker maker;
  maker.houses({1000.3, -500.7, 20}, 6, 23.3);
  const Scene& city = maker.scene;
  const WorldLattice lattice = *fit_lattice(city, -8);
  const SnappedScene whole = *snap(city);
  Scene part = city;
  part.objects.erase(part.objects.begin(), part.objects.end() - 1);
  part.objects[0].first_triangle = 0;
  const std::size_t gone = city.triangles.size() - part.objects[0].triangle_count;
  part.triangles.erase(part.triangles.begin(), part.triangles.begin() + static_cast<std::ptrdiff_t>(gone));
  part.triangle_material.resize(part.triangles.size());
  BakeContext context;
  const Result<SnappedScene> last = snap_scene({part, lattice}, context);
  ASSERT_TRUE(last.ok()) << last.error().describe();
  for (const LatticePoint& p : last->mesh.vertices) EXPECT_EQ(std::ranges::count(whole.mesh.vertices, p), 1);
  WorldLattice elsewhere = lattice;
  elsewhere.anchor[0] += 1'000'000;
  EXPECT_FALSE(snap_scene({part, elsewhere}, context).ok());
}

}  // namespace
}  // namespace zc
