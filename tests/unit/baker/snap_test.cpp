// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/repair/snap.h"

#include <gtest/gtest.h>

#include "tests/unit/baker/test_city.h"

namespace zc {
namespace {

using test::SceneMaker;

TEST(Snap, LargeCoordinatesKeepMillimetresRelativeToTheAnchor) {
  SceneMaker maker;
  const glm::dvec3 o(1e7, -1e7, 512.25);
  maker.triangle(o, o + glm::dvec3(1.5, 0, 0), o + glm::dvec3(0, 2.25, 0.5), 0);
  maker.object(ObjectKind::kObject);
  auto snapped = snap_scene(std::move(maker.scene), -8);
  ASSERT_TRUE(snapped.ok());
  EXPECT_EQ(snapped->anchor[0], 10000000LL * 256);
  EXPECT_EQ(snapped->anchor[1], -10000000LL * 256);
  EXPECT_EQ(snapped->anchor[2], 512LL * 256);
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
  auto snapped = snap_scene(std::move(maker.scene), -8);
  ASSERT_TRUE(snapped.ok());
  EXPECT_EQ(snapped->mesh.vertices.size(), 3U);
  EXPECT_EQ(snapped->mesh.faces.size(), 2U);
  EXPECT_EQ(snapped->objects.size(), 1U);
}

TEST(Snap, RefusesEmptyBrokenAndTooWideScenes) {
  EXPECT_FALSE(snap_scene(Scene{}, -8).ok());
  SceneMaker wide;
  wide.triangle({0, 0, 0}, {5e6, 0, 0}, {0, 1, 0}, 0);
  wide.object(ObjectKind::kObject);
  EXPECT_FALSE(snap_scene(std::move(wide.scene), -8).ok());
  SceneMaker broken;
  broken.triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0);
  broken.object(ObjectKind::kObject);
  Scene dangling = broken.scene;
  dangling.triangles[0][1] = 7;
  EXPECT_FALSE(snap_scene(std::move(dangling), -8).ok());
  EXPECT_FALSE(snap_scene(std::move(broken.scene), 3).ok());
}

}  // namespace
}  // namespace zc
