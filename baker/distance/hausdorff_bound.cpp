// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/distance/hausdorff_bound.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <span>
#include <vector>

namespace zc {
namespace {

constexpr double kSliver = 0.001;  // of what is enough: what is narrower is not cut off

// A convex polygon: a triangle cut by three planes has six corners at most.
struct Polygon {
  std::array<glm::dvec3, 8> corner;
  std::size_t count = 0;

  void add(const glm::dvec3& p) { corner[count++] = p; }
};

double farthest(std::span<const glm::dvec3> points, const DistanceTriangle& t) {
  double most = 0;
  for (const glm::dvec3& p : points) most = std::max(most, t.distance(p));
  return most;
}

// Parts on either side of the plane dot(p, n) = d. What rises less than `least` above it counts as below; what sinks
// less than that below it is no part.
void split(const Polygon& in, const glm::dvec3& n, double d, double least, Polygon& below, Polygon& above) {
  double highest = -std::numeric_limits<double>::infinity();
  double lowest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < in.count; ++i) {
    const double height = glm::dot(in.corner[i], n) - d;
    highest = std::max(highest, height);
    lowest = std::min(lowest, height);
  }
  if (lowest > -least) return;
  if (highest < least) {
    below = in;
    return;
  }
  for (std::size_t i = 0; i < in.count; ++i) {
    const glm::dvec3& a = in.corner[i];
    const glm::dvec3& b = in.corner[(i + 1) % in.count];
    const double ha = glm::dot(a, n) - d;
    const double hb = glm::dot(b, n) - d;
    if (ha <= 0) below.add(a);
    if (ha >= 0) above.add(a);
    if ((ha < 0 && hb > 0) || (ha > 0 && hb < 0)) {
      const glm::dvec3 p = a + (b - a) * (ha / (ha - hb));
      below.add(p);
      above.add(p);
    }
  }
}

void add_fan(const Polygon& polygon, std::vector<Corners>& pieces) {
  for (std::size_t i = 2; i < polygon.count; ++i)
    pieces.push_back({polygon.corner[0], polygon.corner[i - 1], polygon.corner[i]});
}

// Cuts away from `piece` what lies within `offset` of the sides of `t`, as far as all that is near enough, and adds the
// rest to `pieces`; false, and nothing added, where it is not.
bool cut_away(const Corners& piece, const DistanceTriangle& t, double offset, double enough,
              std::vector<Corners>& pieces, double& bound) {
  Polygon inside;
  for (const glm::dvec3& p : piece) inside.add(p);
  const std::array<glm::dvec3, 3> corner = {t.a, t.a + t.ab, t.a + t.ac};
  std::array<Polygon, 3> outside;
  for (std::size_t i = 0; i < 3; ++i) {
    const glm::dvec3 out = glm::normalize(glm::cross(corner[(i + 1) % 3] - corner[i], t.normal));
    Polygon rest;
    split(inside, out, glm::dot(corner[i], out) + offset, kSliver * enough, rest, outside[i]);
    inside = rest;
    if (inside.count < 3) return false;
  }
  const double farthest_inside = farthest(std::span(inside.corner).first(inside.count), t);
  if (farthest_inside > enough) return false;
  bound = std::max(bound, farthest_inside);
  for (const Polygon& polygon : outside) add_fan(polygon, pieces);
  return true;
}

// How far outside the sides of `t` planes intersect no farther than 1 from a corner.
double offset_at_corners(const DistanceTriangle& t) {
  const std::array<glm::dvec3, 3> along = {glm::normalize(t.ab), glm::normalize(t.ac - t.ab), -glm::normalize(t.ac)};
  double offset = 1;
  for (std::size_t i = 0; i < 3; ++i)
    offset = std::min(offset, std::sqrt(std::max(0.0, (1 + glm::dot(along[i], along[(i + 2) % 3])) / 2)));
  return offset;
}

// The wide margin first: it leaves the least, but is too much at sharp corners.
bool cut_away(const Corners& piece, const DistanceTriangle& t, const HausdorffLimits& limits,
              std::vector<Corners>& pieces, double& bound) {
  return cut_away(piece, t, limits.margin, limits.enough, pieces, bound) ||
         cut_away(piece, t, limits.margin * offset_at_corners(t), limits.enough, pieces, bound);
}

void halve(const Corners& piece, std::size_t side, std::vector<Corners>& pieces) {
  const std::size_t next = (side + 1) % 3;
  const glm::dvec3 middle = (piece[side] + piece[next]) * 0.5;
  for (const std::size_t i : {side, next}) {
    pieces.push_back(piece);
    pieces.back()[i] = middle;
  }
}

}  // namespace

Corners corners_of(const LatticeMesh& mesh, const LatticeFace& face) {
  Corners out;
  for (std::size_t i = 0; i < 3; ++i) out[i] = to_dvec(mesh.vertices[face.v[i]]);
  return out;
}

HausdorffBound hausdorff_bound(const Corners& triangle, const HausdorffLimits& limits,
                               const std::function<const DistanceTriangle*(const glm::dvec3&, double&)>& nearest) {
  HausdorffBound out;
  // Breadth first: what is far outside shows itself in the large pieces.
  std::vector<Corners> pieces = {triangle};
  double farthest_center = 0;
  const DistanceTriangle* hint = nullptr;  // what covered the last piece often covers the next one
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Corners piece = pieces[i];
    if (limits.work != nullptr) ++limits.work->done;
    const bool is_spent = limits.work != nullptr && limits.work->is_spent();
    if (hint != nullptr) {
      const double most = farthest(piece, *hint);
      if (most <= limits.enough) {
        out.bound = std::max(out.bound, most);
        continue;
      }
    }
    const glm::dvec3 center = (piece[0] + piece[1] + piece[2]) / 3.0;
    double distance = std::numeric_limits<double>::infinity();
    const DistanceTriangle* found = is_spent ? hint : nullptr;
    if (found != nullptr) {
      distance = found->distance(center);
    } else {
      found = nearest(center, distance);
    }
    double most = std::numeric_limits<double>::infinity();
    if (found != nullptr) {
      double radius = 0;
      for (const glm::dvec3& p : piece) radius = std::max(radius, glm::distance(p, center));
      most = std::min(farthest(piece, *found), distance + radius);
      hint = found;
    }
    if (most <= limits.enough) {
      out.bound = std::max(out.bound, most);
      continue;
    }
    const bool has_room = pieces.size() < limits.pieces && !is_spent;
    if (has_room && found != nullptr && cut_away(piece, *found, limits, pieces, out.bound)) continue;
    std::size_t longest = 0;
    std::array<double, 3> sides;
    for (std::size_t k = 0; k < 3; ++k) {
      sides[k] = glm::distance(piece[k], piece[(k + 1) % 3]);
      if (sides[k] > sides[longest]) longest = k;
    }
    const bool stops = limits.stop_outside && distance > limits.enough;
    if (stops || !has_room || sides[longest] <= limits.least_piece) {
      out.bound = std::max(out.bound, most);
      if (out.within || distance > farthest_center) out.outside = center;
      farthest_center = std::max(farthest_center, distance);
      out.within = false;
      if (limits.stop_outside) return out;
      continue;
    }
    halve(piece, longest, pieces);
  }
  return out;
}

}  // namespace zc
