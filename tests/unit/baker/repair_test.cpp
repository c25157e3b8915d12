// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/repair/repair.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <map>
#include <set>

#include "baker/distance/lattice_distance.h"
#include "baker/repair/face_edges.h"
#include "tests/unit/baker/stages.h"
#include "tests/unit/baker/test_city.h"

namespace zc {
namespace {

using test::SceneMaker;

constexpr double kStep = 1.0 / 256;

constexpr const char* kFlat = "triangles without area at the lattice step, dropped";
constexpr const char* kRepeated = "repeated triangles, dropped";
constexpr const char* kBackToBack = "triangles back to back with another of their object, dropped";
constexpr const char* kSlivers = "triangles thinner than half a step, dropped";
constexpr const char* kStitched = "open edges a step apart, stitched";
constexpr const char* kTJunctions = "T-junctions, repaired";
constexpr const char* kTJunctionsLeft = "T-junctions left, of objects too dense with them";
constexpr const char* kTurned = "triangles turned to their neighbours' side or outwards";
constexpr const char* kOneSided = "surfaces with one side only, like a Moebius strip";
constexpr const char* kEmptied = "objects left without triangles";

struct Repaired {
  SnappedScene scene;
  RepairReport report;
  std::map<std::string, std::uint64_t> counts;
};

Repaired repaired(Scene scene) {
  Repaired out;
  BakeContext context;
  auto repaired = repair_scene(test::snapped(std::move(scene)), context);
  EXPECT_TRUE(repaired.ok());
  out.scene = std::move(repaired->scene);
  out.report = std::move(repaired->report);
  for (const ImportCount& count : out.report.counts) out.counts[count.what] = count.count;
  return out;
}

// Six times the volume, in cubic steps.
double volume6(const LatticeMesh& mesh) {
  double sum = 0;
  for (const LatticeFace& face : mesh.faces) {
    const LatticeVector a = difference(mesh.vertices[face.v[0]], {});
    const LatticeVector n = cross(difference(mesh.vertices[face.v[1]], mesh.vertices[face.v[0]]),
                                  difference(mesh.vertices[face.v[2]], mesh.vertices[face.v[0]]));
    for (std::size_t i = 0; i < 3; ++i) sum += static_cast<double>(a[i]) * static_cast<double>(n[i]);
  }
  return sum;
}

std::size_t disagreeing_edges(const LatticeMesh& mesh) {
  std::size_t count = 0;
  for_each_edge(face_edges(mesh), [&](std::span<const FaceEdge> edge) {
    if (edge.size() == 2 && edge[0].forward == edge[1].forward) ++count;
  });
  return count;
}

void closed_box(SceneMaker& maker, const glm::dvec3& low, const glm::dvec3& high) {
  maker.box(low, high);
  maker.quad({low.x, low.y, low.z}, {low.x, high.y, low.z}, {high.x, high.y, low.z}, {high.x, low.y, low.z}, 0);
}

TEST(Repair, SoundObjectsStayAsTheyAre) {
  SceneMaker maker;
  closed_box(maker, {0, 0, 0}, {8, 6, 4});
  maker.object(ObjectKind::kObject);
  maker.terrain({20, 0, 0}, 8, 5.5);
  const SnappedScene snapped = test::snapped(maker.scene);
  const Repaired out = repaired(std::move(maker.scene));
  EXPECT_EQ(out.scene.mesh, snapped.mesh);
  EXPECT_TRUE(out.report.counts.empty());
  EXPECT_EQ(out.report.open_edges, 4U * 8);
  EXPECT_EQ(out.report.border_error_m, 0);
}

TEST(Repair, DropsWhatIsFlatOrRepeatedByKind) {
  SceneMaker maker;
  const glm::dvec3 a(0), b(1, 0, 0), c(0, 1, 0), d(0, 0, 1);
  maker.triangle(a, b, c, 0);
  maker.triangle(b, c, a, 1);                           // rotated copy
  maker.triangle(a, c, b, 0);                           // back to back in the same object
  maker.triangle(a, b, b + glm::dvec3(1e-4, 0, 0), 0);  // flat on the lattice
  maker.triangle(b, a, d, 0);
  maker.object(ObjectKind::kObject);
  maker.triangle(c, b, a, 0);  // the other side belongs to another object: stays
  maker.object(ObjectKind::kObject);
  maker.triangle(a, b, c, 0);  // a copy of the first object's
  maker.object(ObjectKind::kObject);
  const Repaired out = repaired(std::move(maker.scene));
  EXPECT_EQ(out.scene.mesh.vertices.size(), 4U);
  EXPECT_EQ(out.scene.mesh.faces.size(), 3U);
  EXPECT_EQ(out.scene.objects.size(), 2U);
  EXPECT_EQ(out.counts,
            (std::map<std::string, std::uint64_t>{{kFlat, 1}, {kRepeated, 2}, {kBackToBack, 1}, {kEmptied, 1}}));
}

TEST(Repair, FailsWhenNothingHasAnArea) {
  SceneMaker flat;
  flat.triangle({0, 0, 0}, {1, 0, 0}, {2, 0, 0}, 0);
  flat.object(ObjectKind::kObject);
  BakeContext context;
  EXPECT_FALSE(repair_scene(test::snapped(std::move(flat.scene)), context).ok());
}

TEST(Repair, AClosedObjectFacesOutwardsHoweverItCame) {
  for (const unsigned flips : {0b111111111111U, 0b010110100101U, 0b100000000000U, 0U}) {
    SceneMaker maker;
    closed_box(maker, {1e6, 1e7, 30}, {1e6 + 8, 1e7 + 6, 34});
    unsigned flipped = 0;
    for (std::size_t i = 0; i < 12; ++i) {
      if ((flips >> i & 1U) == 0) continue;
      std::swap(maker.scene.triangles[i][1], maker.scene.triangles[i][2]);
      ++flipped;
    }
    maker.object(ObjectKind::kObject);
    Repaired out = repaired(std::move(maker.scene));
    EXPECT_EQ(out.counts[kTurned], flipped);
    EXPECT_EQ(disagreeing_edges(out.scene.mesh), 0U);
    EXPECT_EQ(volume6(out.scene.mesh), 6.0 * 8 * 6 * 4 * 256 * 256 * 256);
    EXPECT_EQ(out.report.open_edges, 0U);
  }
}

TEST(Repair, GroundFacesUpAndOpenSheetsTheWayMostOfThemDid) {
  SceneMaker maker;
  maker.quad({0, 0, 0}, {0, 10, 0}, {10, 10, 1}, {10, 0, 1}, 2);  // downwards
  maker.object(ObjectKind::kGround);
  maker.quad({20, 0, 0}, {20, 0, 9}, {29, 0, 9}, {29, 0, 0}, 0);
  maker.triangle({29, 0, 0}, {29, 0, 9}, {31, 0, 0}, 0);  // smaller, turned away from the rest
  std::swap(maker.scene.triangles.back()[1], maker.scene.triangles.back()[2]);
  maker.object(ObjectKind::kObject);
  Repaired out = repaired(std::move(maker.scene));
  EXPECT_EQ(out.counts[kTurned], 3U);
  EXPECT_EQ(disagreeing_edges(out.scene.mesh), 0U);
  for (const LatticeFace& face : out.scene.mesh.faces) {
    const auto& p = out.scene.mesh.vertices;
    const LatticeVector n = cross(difference(p[face.v[1]], p[face.v[0]]), difference(p[face.v[2]], p[face.v[0]]));
    EXPECT_GT(face.ground ? n[2] : n[1], 0);
  }
}

TEST(Repair, AMoebiusStripIsCountedAndKeptWhole) {
  SceneMaker maker;
  constexpr int kParts = 12;
  const auto at = [](int i, double side) {
    const double turn = i * 2 * 3.14159265358979 / kParts;
    const double twist = turn / 2;
    const double r = 10 + side * std::cos(twist);
    return glm::dvec3(r * std::cos(turn), r * std::sin(turn), side * std::sin(twist));
  };
  for (int i = 0; i < kParts; ++i) maker.quad(at(i, -2), at(i + 1, -2), at(i + 1, 2), at(i, 2), 0);
  maker.object(ObjectKind::kObject);
  Repaired out = repaired(std::move(maker.scene));
  EXPECT_EQ(out.counts[kOneSided], 1U);
  EXPECT_EQ(out.scene.mesh.faces.size(), 2U * kParts);
}

TEST(Repair, VerticesOnAnEdgeAreInsertedThere) {
  SceneMaker maker;
  // One long triangle touches a row of short ones: seven vertices lie on its long side.
  const glm::dvec3 low(0), high(8, 0, 8);
  maker.triangle(low, high, {4, -5, 4}, 0);
  for (int i = 0; i < 8; ++i) {
    const auto at = [](int k) { return glm::dvec3(k, 0, k); };
    maker.triangle(at(i + 1), at(i), {4, 5, 4}, 0);
  }
  maker.object(ObjectKind::kObject);
  Repaired out = repaired(std::move(maker.scene));
  EXPECT_EQ(out.counts[kTJunctions], 7U);
  EXPECT_EQ(out.scene.mesh.faces.size(), 16U);
  EXPECT_EQ(out.report.open_edges, 4U);
  EXPECT_EQ(disagreeing_edges(out.scene.mesh), 0U);
  EXPECT_EQ(out.report.border_error_m, 0);
}

TEST(Repair, VerticesWithinHalfAStepOfAnEdgeAreInsertedAndTheMoveIsReported) {
  SceneMaker maker;
  const double off = kStep;  // of a vertex near the end of a diagonal: less than half a step away from the line
  maker.triangle({0, 0, 0}, {9, 3, 0}, {4, 0, 8}, 0);
  maker.triangle({3, 1 + off / 4, 0}, {0, 0, 0}, {2, 0, -7}, 0);  // snaps to the line
  maker.triangle({9, 3, 0}, {3, 1, 0}, {4, 0, -8}, 0);
  maker.triangle({20, 0, 0}, {29, 0, 3 * off}, {24, 9, 0}, 0);
  maker.triangle({22, 0, off}, {20, 0, 0}, {22, -6, 0}, 0);  // a third of a step off
  maker.triangle({29, 0, 3 * off}, {22, 0, off}, {26, -6, 0}, 0);
  maker.object(ObjectKind::kObject);
  Repaired out = repaired(std::move(maker.scene));
  EXPECT_EQ(out.counts[kTJunctions], 2U);
  EXPECT_NEAR(out.report.border_error_m, kStep / 3, kStep / 100);
}

TEST(Repair, VerticesThatOnlyTouchAnEdgeOrLieOnASoundOneStayOut) {
  SceneMaker maker;
  closed_box(maker, {0, 0, 0}, {8, 8, 8});
  maker.triangle({4, 0, 8}, {3, -2, 8}, {5, -2, 8}, 0);  // its corner on an edge of the box
  maker.triangle({20, 0, 0}, {28, 0, 0}, {24, 6, 0}, 0);
  maker.triangle({24, 0, 0}, {23, -2, 0}, {25, -2, 0}, 0);  // its corner on an open edge
  maker.object(ObjectKind::kObject);
  Repaired out = repaired(std::move(maker.scene));
  EXPECT_EQ(out.counts[kTJunctions], 0U);
  EXPECT_EQ(out.scene.mesh.faces.size(), 12U + 3);
}

TEST(Repair, RoadsAndTerrainMeetAcrossObjects) {
  SceneMaker maker;
  maker.quad({0, 0, 0}, {40, 0, 0}, {40, 9, 1}, {0, 9, 1}, 2);
  maker.object(ObjectKind::kGround);
  for (int i = 0; i < 4; ++i) {
    maker.quad({10.0 * i, -9, 0}, {10.0 * i + 10, -9, 0}, {10.0 * i + 10, 0, 0}, {10.0 * i, 0, 0}, 3);
    maker.object(ObjectKind::kGround);
  }
  Repaired out = repaired(std::move(maker.scene));
  EXPECT_EQ(out.counts[kTJunctions], 3U);
  EXPECT_EQ(out.scene.objects.size(), 5U);
  std::uint32_t next = 0;
  for (const SceneObject& object : out.scene.objects) {
    EXPECT_EQ(object.first_triangle, next);
    const bool road = object.id != "0";
    EXPECT_EQ(object.triangle_count, road ? 2U : 5U);
    for (std::uint32_t i = 0; i < object.triangle_count; ++i)
      EXPECT_EQ(out.scene.mesh.faces[next + i].material, road ? 3 : 2);
    next += object.triangle_count;
  }
  EXPECT_EQ(next, out.scene.mesh.faces.size());
}

TEST(Repair, TJunctionsDoNotMultiplyWithoutEnd) {
  SceneMaker maker;
  // Every triangle has the same line for a side, from another start to another end.
  for (int i = 0; i < 300; ++i) maker.triangle({i * 0.01, 0, 0}, {100 - i * 0.013, 0, 0}, {50, 1, i * 0.1}, 0);
  maker.object(ObjectKind::kObject);
  Repaired out = repaired(std::move(maker.scene));
  EXPECT_GT(out.counts[kTJunctionsLeft], 0U);
  EXPECT_LE(out.scene.mesh.faces.size(), 2U * 300 + 64);
}

TEST(Repair, EdgesThatTheLatticeToreAreStitched) {
  SceneMaker maker;
  // Corners that were meant to be equal lie on both sides of a rounding boundary.
  const double tear = kStep / 2;
  maker.quad({0, 0, 0}, {5 + tear - 1e-6, 0, 0}, {5 + tear - 1e-6, 5, 0}, {0, 5, 0}, 0);
  maker.quad({5 + tear + 1e-6, 0, 0}, {9, 0, 0}, {9, 5, 0}, {5 + tear + 1e-6, 5, 0}, 0);
  maker.object(ObjectKind::kObject);
  Repaired out = repaired(std::move(maker.scene));
  EXPECT_EQ(out.counts[kStitched], 1U);
  EXPECT_EQ(out.report.open_edges, 6U);
  EXPECT_EQ(out.scene.mesh.vertices.size(), 6U);
  EXPECT_DOUBLE_EQ(out.report.border_error_m, kStep);
}

TEST(Repair, SheetsAStepApartBecomeOneAndSayHow) {
  SceneMaker maker;
  maker.quad({0, 0, 0}, {5, 0, 0}, {5, 0, 5}, {0, 0, 5}, 0);
  maker.quad({5, kStep, 0}, {0, kStep, 0}, {0, kStep, 5}, {5, kStep, 5}, 0);
  maker.object(ObjectKind::kObject);
  Repaired out = repaired(std::move(maker.scene));
  EXPECT_GT(out.counts[kStitched], 0U);
  EXPECT_EQ(out.scene.mesh.faces.size() + out.counts[kBackToBack] + out.counts[kRepeated] + out.counts[kFlat], 4U);
  EXPECT_GE(out.scene.mesh.faces.size(), 2U);
  EXPECT_DOUBLE_EQ(out.report.border_error_m, kStep);
}

TEST(Repair, AClosedBoxAStepThickKeepsItsWidth) {
  SceneMaker maker;
  closed_box(maker, {0, 0, 0}, {5, kStep, 5});
  maker.object(ObjectKind::kObject);
  Repaired out = repaired(std::move(maker.scene));
  EXPECT_TRUE(out.report.counts.empty());
  EXPECT_EQ(out.scene.mesh.faces.size(), 12U);
}

TEST(Repair, SliversGoWhereTheirNeighboursCanMeet) {
  SceneMaker maker;
  const glm::dvec3 a(0), b(9, 0, 0), n(4, 0, 0);
  maker.triangle(a, b, {4, -6, 0}, 0);
  maker.triangle(n, a, {2, 5, 0}, 0);
  maker.triangle(b, n, {6, 5, 0}, 0);
  maker.triangle(a, n, b, 0);  // no area: gone, and its neighbours touch
  maker.object(ObjectKind::kObject);
  maker.triangle(a, {9, 3 * kStep, 0}, {9, 2 * kStep, 0.1}, 0);  // thin and alone: a wire
  maker.object(ObjectKind::kObject);
  Repaired out = repaired(std::move(maker.scene));
  EXPECT_EQ(out.counts[kFlat], 1U);
  EXPECT_EQ(out.counts[kTJunctions], 1U);
  EXPECT_EQ(out.scene.objects.size(), 2U);
  EXPECT_EQ(out.report.open_edges, 6U + 3);

  SceneMaker thin;
  const glm::dvec3 off(5, 2 * kStep, 0);  // the line from a to (9, 3 steps, 0) passes a third of a step away
  const glm::dvec3 end(9, 3 * kStep, 0);
  thin.triangle(a, end, {4, -6, 0}, 0);
  thin.triangle(a, off, end, 0);
  thin.triangle(off, a, {2, 5, 0}, 0);
  thin.triangle(end, off, {6, 5, 0}, 0);
  std::swap(thin.scene.triangles[0][1], thin.scene.triangles[0][2]);
  thin.object(ObjectKind::kObject);
  Repaired sliver = repaired(std::move(thin.scene));
  EXPECT_EQ(sliver.counts[kSlivers], 1U);
  EXPECT_EQ(sliver.counts[kTJunctions], 1U);
  EXPECT_EQ(sliver.scene.mesh.faces.size(), 4U);
  EXPECT_EQ(sliver.report.open_edges, 6U);
  EXPECT_LE(sliver.report.border_error_m, kStep / 2);
  EXPECT_GT(sliver.report.border_error_m, 0);
}

TEST(Repair, GivesTheSameAtAnyThreadCount) {
  const auto make = [] {
    SceneMaker maker;
    maker.scene = test::small_city();
    std::uint32_t state = 1;
    const auto random = [&] {
      state = state * 1664525U + 1013904223U;
      return static_cast<double>(state >> 8U) / (1U << 24U);
    };
    for (auto& triangle : maker.scene.triangles)
      if (random() < 0.3) std::swap(triangle[1], triangle[2]);
    for (auto& p : maker.scene.positions) p += glm::dvec3(random(), random(), random()) * 0.004;
    return std::move(maker.scene);
  };
  std::vector<LatticeMesh> meshes;
  for (const int threads : {1, 2, 4}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    tbb::task_arena arena(threads);
    arena.execute([&] {
      Repaired out = repaired(make());
      EXPECT_GT(out.counts[kTurned], 100U);
      EXPECT_GT(out.counts[kStitched], 10U);
      meshes.push_back(std::move(out.scene.mesh));
    });
  }
  EXPECT_EQ(meshes[0], meshes[1]);
  EXPECT_EQ(meshes[0], meshes[2]);
}

}  // namespace
}  // namespace zc
