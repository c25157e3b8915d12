// SPDX-License-Identifier: GPL-3.0-or-later
// A planar polygon with holes becomes triangles over its own corners; no corner is added or moved.
// Triangles and convex quads are cut directly; everything else goes to the constrained Delaunay triangulation.
// Units: metres. Untrusted input: any rings, however degenerate. Thread-safe: no state.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace zc {

struct Polygon {
  std::vector<glm::dvec3> points;        // outer ring, then holes; rings are not closed explicitly
  std::vector<std::uint32_t> ring_ends;  // one past each ring's last point

  void clear();
  void add_point(const glm::dvec3& point) { points.push_back(point); }
  void end_ring() { ring_ends.push_back(static_cast<std::uint32_t>(points.size())); }
};

enum class PolygonOutcome {
  kTriangulated,
  kNoArea,    // fewer than three distinct corners, or all on one line: no triangles
  kCrossing,  // rings cross: the outer ring alone was cut, by ear clipping
};

// Area-weighted normal of the first ring (twice its area long), positive where the ring runs anticlockwise.
glm::dvec3 newell_normal(const Polygon& polygon);

// Appends triangles of indices into polygon.points, oriented as the outer ring is.
PolygonOutcome triangulate_polygon(const Polygon& polygon, std::vector<std::array<std::uint32_t, 3>>& out);

}  // namespace zc
