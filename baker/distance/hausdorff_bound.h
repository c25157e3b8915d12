// SPDX-License-Identifier: GPL-3.0-or-later
// Distances from all points of a triangle to a surface, bounded from above. Where the corners of a piece lie near one
// and the same triangle of the surface, so does all of the piece, distances to what is convex being convex. What a
// triangle of the surface covers is cut away from a piece; where none covers a part, the piece is halved.
// Source: the branch and bound of Tang, Lee & Kim 2009 ("Interactive Hausdorff distance computation"), with that test
// and that cut. Units: steps. Thread-safe: no state.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>

#include "baker/distance/distance_bvh.h"

namespace zc {

using Corners = std::array<glm::dvec3, 3>;

Corners corners_of(const LatticeMesh& mesh, const LatticeFace& face);

struct HausdorffLimits {
  double enough = 0;          // distances up to this are all alike
  double margin = 0;          // how far beyond its sides a triangle of the surface is taken to cover: less than enough
  double least_piece = 1;     // pieces with shorter sides are not halved
  std::uint32_t pieces = 0;   // at most
  bool stop_outside = false;  // stop at the first piece that is not within `enough`
  Work* work = nullptr;       // when it is spent, pieces are not halved any more; one a piece is added to it
};

struct HausdorffBound {
  double bound = 0;         // no point of the triangle is farther
  glm::dvec3 outside = {};  // farthest centre of the pieces that are not known to be within `enough`, if any
  bool within = true;       // no such piece
};

// nearest(p, distance): the surface's triangle closest to p, or null; sets how far it is.
HausdorffBound hausdorff_bound(const Corners& triangle, const HausdorffLimits& limits,
                               const std::function<const DistanceTriangle*(const glm::dvec3&, double&)>& nearest);

}  // namespace zc
