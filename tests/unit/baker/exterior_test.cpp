// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/exterior/exterior.h"

#include <gtest/gtest.h>

#include <map>

#include "tests/unit/baker/stages.h"
#include "tests/unit/baker/test_city.h"

namespace zc {
namespace {

// Closed on all sides, faces outwards.
void closed_box(test::SceneMaker& maker, const glm::dvec3& low, const glm::dvec3& high,
                ObjectKind kind = ObjectKind::kObject) {
  maker.box(low, high);
  maker.quad({low.x, high.y, low.z}, {high.x, high.y, low.z}, {high.x, low.y, low.z}, low, 0);
  maker.object(kind);
}

// A box whose side at y = 0 is a frame around an opening in its middle, or is closed by a pane there.
void room(test::SceneMaker& maker, const glm::dvec3& high, double opening_m, bool pane) {
  const auto wall = [&](double x0, double x1, double z0, double z1) {
    maker.quad({x0, 0, z0}, {x1, 0, z0}, {x1, 0, z1}, {x0, 0, z1}, 0);
  };
  const double x0 = (high.x - opening_m) / 2;
  const double z0 = (high.z - opening_m) / 2;
  const double x1 = x0 + opening_m;
  const double z1 = z0 + opening_m;
  wall(0, x0, 0, z0), wall(x0, x1, 0, z0), wall(x1, high.x, 0, z0);
  wall(0, x0, z0, z1), wall(x1, high.x, z0, z1);
  wall(0, x0, z1, high.z), wall(x0, x1, z1, high.z), wall(x1, high.x, z1, high.z);
  if (pane) wall(x0, x1, z0, z1);
  maker.quad({high.x, 0, 0}, {high.x, high.y, 0}, {high.x, high.y, high.z}, {high.x, 0, high.z}, 0);
  maker.quad({high.x, high.y, 0}, {0, high.y, 0}, {0, high.y, high.z}, {high.x, high.y, high.z}, 0);
  maker.quad({0, high.y, 0}, {0, 0, 0}, {0, 0, high.z}, {0, high.y, high.z}, 0);
  maker.quad({0, 0, high.z}, {high.x, 0, high.z}, {high.x, high.y, high.z}, {0, high.y, high.z}, 1);
  maker.quad({0, high.y, 0}, {high.x, high.y, 0}, {high.x, 0, 0}, {0, 0, 0}, 0);
  maker.object(ObjectKind::kObject);
}

Result<ExteriorScene> exterior_of(const test::SceneMaker& maker, unsigned threads = 2) {
  BakeContext context(threads);
  return drop_interior(test::snapped(maker.scene), context);
}

// Faces of every object that is left.
std::map<std::string, std::uint32_t> left(const SnappedScene& scene) {
  std::map<std::string, std::uint32_t> out;
  std::uint32_t next = 0;
  for (const SceneObject& object : scene.objects) {
    EXPECT_EQ(object.first_triangle, next);
    out[object.id] = object.triangle_count;
    next += object.triangle_count;
  }
  EXPECT_EQ(next, scene.mesh.faces.size());
  return out;
}

TEST(Exterior, OfABoxInABoxTheOuterOneStays) {
  test::SceneMaker maker;
  closed_box(maker, {0, 0, 0}, {10, 10, 10});
  closed_box(maker, {4, 4, 4}, {6, 6, 6});
  for (const unsigned threads : {1U, 4U}) {
    const Result<ExteriorScene> out = exterior_of(maker, threads);
    ASSERT_TRUE(out.ok()) << out.error().describe();
    EXPECT_EQ(out->dropped, 12U);
    const SnappedScene& scene = out->scene;
    EXPECT_EQ(left(scene), (std::map<std::string, std::uint32_t>{{"0", 12}}));
    EXPECT_EQ(scene.mesh.vertices.size(), 8U);
    for (const LatticeFace& face : scene.mesh.faces)
      for (const std::uint32_t v : face.v)
        for (std::size_t axis = 0; axis < 3; ++axis)
          EXPECT_EQ(scene.mesh.vertices[v][axis] == 0 || scene.mesh.vertices[v][axis] == 2560, true);
  }
}

// Rays in single precision would start metres off the faces there.
TEST(Exterior, AWorldTooWideForRaysStaysWhole) {
  test::SceneMaker maker;
  closed_box(maker, {0, 0, 0}, {10, 10, 10});
  closed_box(maker, {1, 1, 1}, {9, 9, 9});
  closed_box(maker, {1.9e6, 0, 0}, {1.9e6 + 10, 10, 10});
  const auto out = exterior_of(maker);
  ASSERT_TRUE(out.ok());
  EXPECT_EQ(out->dropped, 0U);
  ASSERT_EQ(out->scene.notes.size(), 1U);
  EXPECT_EQ(out->scene.notes[0].count, 36U);
}

TEST(Exterior, ARoomWithAnOpenWindowStaysAndSoDoesWhatStandsInIt) {
  for (const double opening_m : {1.0, 0.2}) {
    for (const bool pane : {false, true}) {
      test::SceneMaker maker;
      room(maker, {6, 5, 3}, opening_m, pane);
      closed_box(maker, {0.5, 3, 0.5}, {2, 4.5, 1.5});  // in a corner that the window does not face
      const Result<ExteriorScene> out = exterior_of(maker);
      ASSERT_TRUE(out.ok());
      EXPECT_EQ(out->dropped, pane ? 12U : 0U) << opening_m;
    }
  }
}

// A cupboard with its door ajar in a room with a window: no ray leads straight out.
TEST(Exterior, WhatIsSeenRoundCornersStays) {
  test::SceneMaker maker;
  room(maker, {6, 5, 3}, 1, false);
  maker.box({4, 3, 1}, {5, 4, 2});  // without its floor, half a metre above the room's
  maker.object(ObjectKind::kObject);
  closed_box(maker, {4.3, 3.3, 1.6}, {4.6, 3.6, 1.8});
  const Result<ExteriorScene> out = exterior_of(maker);
  ASSERT_TRUE(out.ok());
  EXPECT_EQ(out->dropped, 0U);
}

// The lower one's wall stays too: its room and the street face the same wall of the higher one.
TEST(Exterior, WallsBetweenBuildingsThatTouchGoUnlessAStripOfThemShows) {
  for (const double lower_m : {0.0, 0.1, 4.0}) {
    test::SceneMaker maker;
    closed_box(maker, {0, 0, 0}, {8, 8, 9});
    closed_box(maker, {8, 0, 0}, {16, 8, 9 - lower_m});
    const Result<ExteriorScene> out = exterior_of(maker);
    ASSERT_TRUE(out.ok());
    const std::uint32_t walls = lower_m == 0 ? 10 : 12;
    EXPECT_EQ(left(out->scene), (std::map<std::string, std::uint32_t>{{"0", walls}, {"1", walls}})) << lower_m;
  }
}

TEST(Exterior, GroundStaysWhereverItIs) {
  test::SceneMaker maker;
  closed_box(maker, {0, 0, 0}, {10, 10, 10});
  closed_box(maker, {4, 4, 4}, {6, 6, 6}, ObjectKind::kGround);
  const Result<ExteriorScene> out = exterior_of(maker);
  ASSERT_TRUE(out.ok());
  EXPECT_EQ(out->dropped, 0U);
}

}  // namespace
}  // namespace zc
