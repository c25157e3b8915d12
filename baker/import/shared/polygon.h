// SPDX-License-Identifier: GPL-3.0-or-later
// A planar polygon with holes becomes triangles over its own corners, and the places where its outer ring crosses
// itself; no corner is moved. Triangles and convex quads are cut directly; everything else goes to the constrained
// Delaunay triangulation. Units: metres. Untrusted input: any rings, however degenerate. Thread-safe: no state.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace zc {

struct Polygon {
  std::vector<glm::dvec3> points;        // outer ring, then holes; rings are not closed explicitly; then the crossings
  std::vector<std::uint32_t> ring_ends;  // one past each ring's last point
  struct Crossing {
    std::uint32_t from = 0;  // points[from] + part * (points[to] - points[from])
    std::uint32_t to = 0;
    double part = 0;
  };
  std::vector<Crossing> crossings;  // what triangulate_polygon() added to the points, in their order

  void clear();
  void add_point(const glm::dvec3& point) { points.push_back(point); }
  void end_ring() { ring_ends.push_back(static_cast<std::uint32_t>(points.size())); }
};

enum class PolygonOutcome {
  kTriangulated,
  kNoArea,        // fewer than three distinct corners, or all on one line: no triangles
  kOutOfRange,    // coordinates that are not finite or beyond kMaxCoordinateM: no triangles
  kCovered,       // its holes leave nothing: no triangles
  kSelfCrossing,  // the outer ring crosses itself: cut into the pieces that it encloses
  kTangled,       // rings cross too often, or run along themselves: the outer one alone, cut by ear clipping
};

struct PolygonCut {
  PolygonOutcome outcome = PolygonOutcome::kTriangulated;
  std::uint32_t filled_holes = 0;  // that cross the outer ring or another hole, or lie in a ring that crosses itself
};

// What is lost, as notes say it; null where nothing is.
const char* loss_of(PolygonOutcome outcome);
inline constexpr const char* kFilledHoles = "holes that cross another ring, filled";

// Area-weighted normal of the first ring (twice its area long), positive where the ring runs anticlockwise.
glm::dvec3 newell_normal(const Polygon& polygon);

// Appends triangles of indices into polygon.points, oriented as the outer ring is; holes may touch, nest and repeat.
// Adds points where the outer ring crosses itself, and nowhere else.
PolygonCut triangulate_polygon(Polygon& polygon, std::vector<std::array<std::uint32_t, 3>>& out);

}  // namespace zc
