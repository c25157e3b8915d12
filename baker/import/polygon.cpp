// SPDX-License-Identifier: GPL-3.0-or-later
// Normal after Newell (Sutherland, Sproull, Schumacker 1974); ear clipping after Meisters 1975.
#include "baker/import/polygon.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <numeric>

#include "baker/import/triangulate.h"

namespace zc {
namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

// Ear clipping looks at every corner for every ear: beyond this a fan, or a hostile ring takes hours.
constexpr std::size_t kMaxEarCorners = 2000;
// A ring is a line when its area is below this share of its squared perimeter.
constexpr double kFlat = 1e-12;

// The polygon without consecutive duplicates and rings of fewer than three corners, projected onto its plane.
struct FlatPolygon {
  std::vector<glm::dvec2> points;
  std::vector<std::uint32_t> source;  // index into Polygon::points
  std::vector<std::uint32_t> ring_ends;
};

double cross(const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; }
double turn(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) { return cross(b - a, c - a); }

void keep_distinct(const Polygon& polygon, FlatPolygon& flat) {
  std::uint32_t begin = 0;
  for (const std::uint32_t end : polygon.ring_ends) {
    const std::size_t ring_begin = flat.source.size();
    for (std::uint32_t i = begin; i < end; ++i)
      if (flat.source.size() == ring_begin || polygon.points[flat.source.back()] != polygon.points[i])
        flat.source.push_back(i);
    while (flat.source.size() > ring_begin + 1 &&
           polygon.points[flat.source.back()] == polygon.points[flat.source[ring_begin]])
      flat.source.pop_back();
    if (flat.source.size() < ring_begin + 3) {
      flat.source.resize(ring_begin);
      if (begin == 0) return;  // no outer ring, no polygon
    } else {
      flat.ring_ends.push_back(static_cast<std::uint32_t>(flat.source.size()));
    }
    begin = end;
  }
}

void project(const Polygon& polygon, const glm::dvec3& normal, FlatPolygon& flat) {
  const glm::dvec3 n = glm::normalize(normal);
  const glm::dvec3 helper = std::abs(n.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 u = glm::normalize(glm::cross(helper, n));
  const glm::dvec3 v = glm::cross(n, u);
  const glm::dvec3 origin = polygon.points[flat.source.front()];
  for (const std::uint32_t i : flat.source) {
    const glm::dvec3 d = polygon.points[i] - origin;
    flat.points.emplace_back(glm::dot(d, u), glm::dot(d, v));
  }
}

bool cut_convex_quad(const Polygon& polygon, const FlatPolygon& flat, Triangles& out) {
  const auto& p = flat.points;
  for (std::size_t i = 0; i < 4; ++i)
    if (turn(p[i], p[(i + 1) % 4], p[(i + 2) % 4]) <= 0) return false;
  const auto& s = flat.source;
  const auto length = [&](std::uint32_t a, std::uint32_t b) {
    return glm::distance(polygon.points[a], polygon.points[b]);
  };
  if (length(s[0], s[2]) <= length(s[1], s[3])) {
    out.push_back({s[0], s[1], s[2]});
    out.push_back({s[0], s[2], s[3]});
  } else {
    out.push_back({s[0], s[1], s[3]});
    out.push_back({s[1], s[2], s[3]});
  }
  return true;
}

bool is_ear(const FlatPolygon& flat, const std::vector<std::uint32_t>& ring, std::size_t at) {
  const std::size_t n = ring.size();
  const glm::dvec2 a = flat.points[ring[(at + n - 1) % n]];
  const glm::dvec2 b = flat.points[ring[at]];
  const glm::dvec2 c = flat.points[ring[(at + 1) % n]];
  if (turn(a, b, c) <= 0) return false;
  return std::none_of(ring.begin(), ring.end(), [&](std::uint32_t i) {
    const glm::dvec2 p = flat.points[i];
    return p != a && p != b && p != c && turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
  });
}

void clip_ears(const FlatPolygon& flat, Triangles& out) {
  std::vector<std::uint32_t> ring(flat.ring_ends.front());
  std::iota(ring.begin(), ring.end(), 0U);
  const auto emit = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    out.push_back({flat.source[a], flat.source[b], flat.source[c]});
  };
  if (ring.size() > kMaxEarCorners) {
    for (std::size_t i = 1; i + 1 < ring.size(); ++i) emit(ring[0], ring[i], ring[i + 1]);
    return;
  }
  while (ring.size() > 3) {
    const std::size_t n = ring.size();
    std::size_t ear = 0;
    while (ear < n && !is_ear(flat, ring, ear)) ++ear;
    if (ear == n) {  // a tangle without ears: the rest as a fan
      for (std::size_t i = 1; i + 1 < n; ++i) emit(ring[0], ring[i], ring[i + 1]);
      return;
    }
    emit(ring[(ear + n - 1) % n], ring[ear], ring[(ear + 1) % n]);
    ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  emit(ring[0], ring[1], ring[2]);
}

double ring_area2(const FlatPolygon& flat, std::uint32_t begin, std::uint32_t end) {
  double sum = 0;
  for (std::uint32_t i = begin + 1; i + 1 < end; ++i)
    sum += turn(flat.points[begin], flat.points[i], flat.points[i + 1]);
  return sum;
}

// Whether the triangles cover what the rings enclose: edges that overlap in part can confuse inside and outside.
bool covers(const FlatPolygon& flat, const Triangles& local) {
  double rings = 0;
  double scale = 0;
  std::uint32_t begin = 0;
  for (const std::uint32_t end : flat.ring_ends) {
    const double area = std::abs(ring_area2(flat, begin, end));
    rings += begin == 0 ? area : -area;
    scale += area;
    begin = end;
  }
  double covered = 0;
  for (const auto& t : local) covered += turn(flat.points[t[0]], flat.points[t[1]], flat.points[t[2]]);
  return std::abs(covered - rings) <= 1e-6 * scale;
}

}  // namespace

void Polygon::clear() {
  points.clear();
  ring_ends.clear();
}

glm::dvec3 newell_normal(const Polygon& polygon) {
  glm::dvec3 normal(0);
  if (polygon.ring_ends.empty() || polygon.ring_ends.front() == 0) return normal;
  const std::uint32_t end = polygon.ring_ends.front();
  const glm::dvec3 origin = polygon.points.front();  // city coordinates are large: sum near zero
  for (std::uint32_t i = 0; i < end; ++i)
    normal += glm::cross(polygon.points[i] - origin, polygon.points[i + 1 < end ? i + 1 : 0] - origin);
  return normal;
}

PolygonOutcome triangulate_polygon(const Polygon& polygon, Triangles& out) {
  FlatPolygon flat;
  keep_distinct(polygon, flat);
  if (flat.ring_ends.empty()) return PolygonOutcome::kNoArea;
  const glm::dvec3 normal = newell_normal(polygon);
  double perimeter = 0;
  for (std::uint32_t i = 0; i < flat.ring_ends.front(); ++i)
    perimeter += glm::distance(polygon.points[flat.source[i]],
                               polygon.points[flat.source[i + 1 < flat.ring_ends.front() ? i + 1 : 0]]);
  const double area2 = glm::length(normal);
  if (!(area2 > kFlat * perimeter * perimeter) || !std::isfinite(area2)) return PolygonOutcome::kNoArea;

  if (flat.source.size() == 3) {
    out.push_back({flat.source[0], flat.source[1], flat.source[2]});
    return PolygonOutcome::kTriangulated;
  }
  project(polygon, normal, flat);
  if (flat.source.size() == 4 && cut_convex_quad(polygon, flat, out)) return PolygonOutcome::kTriangulated;

  Triangles local;
  if (triangulate_rings(flat.points, flat.ring_ends, local) && covers(flat, local)) {
    for (const auto& t : local) out.push_back({flat.source[t[0]], flat.source[t[1]], flat.source[t[2]]});
    return PolygonOutcome::kTriangulated;
  }
  clip_ears(flat, out);
  return PolygonOutcome::kCrossing;
}

}  // namespace zc
