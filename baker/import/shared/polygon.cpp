// SPDX-License-Identifier: GPL-3.0-or-later
// Normal after Newell (Sutherland, Sproull, Schumacker 1974); ear clipping after Meisters 1975.
#include "baker/import/shared/polygon.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <numeric>
#include <optional>

#include "baker/import/shared/scene_builder.h"
#include "baker/import/shared/triangulate.h"

namespace zc {
namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

// Ear clipping visits every corner for every ear: beyond this a fan, or a hostile ring takes hours.
constexpr std::size_t kMaxEarCorners = 2000;
// Of rings at odds with each other or with themselves, all edges are compared with all.
constexpr std::size_t kMaxOddCorners = 1000;
constexpr std::size_t kMaxOddHoles = 64;
constexpr std::size_t kMaxPieces = 64;
// A corner further away than the earth is wide makes a line of any ring.
constexpr double kMaxPerimeterM = 1e9;
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

bool is_within(const FlatPolygon& flat, std::uint32_t begin, std::uint32_t end, const glm::dvec2& p) {
  bool within = false;
  for (std::uint32_t i = begin; i < end; ++i) {
    const glm::dvec2& a = flat.points[i];
    const glm::dvec2& b = flat.points[i + 1 < end ? i + 1 : begin];
    if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)) within = !within;
  }
  return within;
}

// What lies in the outer ring and in no hole, whatever edges they share. False when rings cross.
bool cut_rings(const FlatPolygon& flat, Triangles& local) {
  Triangles faces;
  if (!triangulate_between(flat.points, flat.ring_ends, faces)) return false;
  for (const auto& t : faces) {
    const glm::dvec2 center = (flat.points[t[0]] + flat.points[t[1]] + flat.points[t[2]]) / 3.0;
    bool keep = is_within(flat, 0, flat.ring_ends[0], center);
    for (std::size_t r = 1; keep && r < flat.ring_ends.size(); ++r)
      keep = !is_within(flat, flat.ring_ends[r - 1], flat.ring_ends[r], center);
    if (keep) local.push_back(t);
  }
  return true;
}

// As cut_rings(), without the holes that cross a ring before them; returns how many. Nothing when the outer ring does.
std::optional<std::uint32_t> cut_sound_rings(const FlatPolygon& flat, Triangles& local) {
  if (flat.points.size() > kMaxOddCorners || flat.ring_ends.size() > 1 + kMaxOddHoles) return std::nullopt;
  FlatPolygon kept;
  std::vector<std::uint32_t> from;  // index in `flat` of the kept points
  std::uint32_t dropped = 0;
  std::uint32_t begin = 0;
  for (const std::uint32_t end : flat.ring_ends) {
    const FlatPolygon before = kept;
    for (std::uint32_t i = begin; i < end; ++i) {
      kept.points.push_back(flat.points[i]);
      from.push_back(i);
    }
    kept.ring_ends.push_back(static_cast<std::uint32_t>(kept.points.size()));
    Triangles faces;
    if (!triangulate_between(kept.points, kept.ring_ends, faces)) {
      if (begin == 0) return std::nullopt;
      kept = before;
      from.resize(kept.points.size());
      ++dropped;
    }
    begin = end;
  }
  Triangles faces;
  cut_rings(kept, faces);
  for (const auto& t : faces) local.push_back({from[t[0]], from[t[1]], from[t[2]]});
  return dropped;
}

// The loops of the outer ring, separated where it crosses itself; each goes round one piece. Nothing when it crosses
// itself too often. Adds the crossings to both polygons.
std::optional<std::vector<std::vector<std::uint32_t>>> loops_of(Polygon& polygon, FlatPolygon& flat) {
  if (flat.ring_ends.front() > kMaxOddCorners) return std::nullopt;
  std::vector<std::vector<std::uint32_t>> open(1);
  open[0].resize(flat.ring_ends.front());
  std::iota(open[0].begin(), open[0].end(), 0U);
  std::vector<std::vector<std::uint32_t>> loops;
  while (!open.empty()) {
    const std::vector<std::uint32_t> ring = std::move(open.back());
    open.pop_back();
    const std::size_t n = ring.size();
    bool separated = false;
    for (std::size_t i = 0; i + 2 < n && !separated; ++i) {
      for (std::size_t j = i + 2; j < n && !separated; ++j) {
        const glm::dvec2 a = flat.points[ring[i]], b = flat.points[ring[i + 1]];
        const glm::dvec2 c = flat.points[ring[j]], d = flat.points[ring[(j + 1) % n]];
        const double side_a = turn(c, d, a), side_b = turn(c, d, b);
        if (side_a * side_b >= 0 || turn(a, b, c) * turn(a, b, d) >= 0) continue;
        if (loops.size() + open.size() + 2 > kMaxPieces) return std::nullopt;
        const double part = side_a / (side_a - side_b);
        const std::uint32_t from = flat.source[ring[i]], to = flat.source[ring[i + 1]];
        const auto crossing = static_cast<std::uint32_t>(flat.points.size());
        flat.points.push_back(a + part * (b - a));
        flat.source.push_back(static_cast<std::uint32_t>(polygon.points.size()));
        polygon.crossings.push_back({from, to, part});
        polygon.points.push_back(polygon.points[from] + part * (polygon.points[to] - polygon.points[from]));
        std::vector<std::uint32_t> inner = {crossing};
        inner.insert(inner.end(), ring.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                     ring.begin() + static_cast<std::ptrdiff_t>(j) + 1);
        std::vector<std::uint32_t> outer(ring.begin(), ring.begin() + static_cast<std::ptrdiff_t>(i) + 1);
        outer.push_back(crossing);
        outer.insert(outer.end(), ring.begin() + static_cast<std::ptrdiff_t>(j) + 1, ring.end());
        open.push_back(std::move(inner));
        open.push_back(std::move(outer));
        separated = true;
      }
    }
    if (!separated) loops.push_back(ring);
  }
  return loops;
}

// All pieces face one way, whichever way round the ring went.
bool cut_loops(Polygon& polygon, FlatPolygon& flat, Triangles& out) {
  const auto loops = loops_of(polygon, flat);
  if (!loops || loops->size() < 2) return false;
  Triangles pieces;
  for (const std::vector<std::uint32_t>& loop : *loops) {
    FlatPolygon piece;
    for (const std::uint32_t i : loop) piece.points.push_back(flat.points[i]);
    piece.ring_ends = {static_cast<std::uint32_t>(loop.size())};
    Triangles local;
    if (loop.size() < 3) continue;
    if (!triangulate_rings(piece.points, piece.ring_ends, local) || !covers(piece, local)) return false;
    for (const auto& t : local)
      pieces.push_back({flat.source[loop[t[0]]], flat.source[loop[t[1]]], flat.source[loop[t[2]]]});
  }
  out.insert(out.end(), pieces.begin(), pieces.end());
  return !pieces.empty();
}

// Of a ring that goes round as much one way as the other: of its widest corner.
glm::dvec3 widest_normal(const Polygon& polygon, const FlatPolygon& flat) {
  glm::dvec3 widest(0);
  const glm::dvec3 origin = polygon.points[flat.source.front()];
  for (std::uint32_t i = 1; i + 1 < flat.ring_ends.front(); ++i) {
    const glm::dvec3 normal =
        glm::cross(polygon.points[flat.source[i]] - origin, polygon.points[flat.source[i + 1]] - origin);
    if (glm::length(normal) > glm::length(widest)) widest = normal;
  }
  return widest;
}

bool usable(const glm::dvec3& p) {
  return std::abs(p.x) <= kMaxCoordinateM && std::abs(p.y) <= kMaxCoordinateM && std::abs(p.z) <= kMaxCoordinateM;
}

}  // namespace

void Polygon::clear() {
  points.clear();
  ring_ends.clear();
  crossings.clear();
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

const char* loss_of(PolygonOutcome outcome) {
  switch (outcome) {
    case PolygonOutcome::kTriangulated:
      return nullptr;
    case PolygonOutcome::kNoArea:
      return "polygons without area, dropped";
    case PolygonOutcome::kOutOfRange:
      return "polygons with coordinates that are not finite or out of range, dropped";
    case PolygonOutcome::kCovered:
      return "polygons that their holes cover, dropped";
    case PolygonOutcome::kSelfCrossing:
      return "polygons that cross themselves, cut into their pieces";
    case PolygonOutcome::kTangled:
      return "polygons whose rings are at odds, outer ring cut roughly";
  }
  return nullptr;
}

PolygonCut triangulate_polygon(Polygon& polygon, Triangles& out) {
  FlatPolygon flat;
  if (!std::all_of(polygon.points.begin(), polygon.points.end(), usable)) return {PolygonOutcome::kOutOfRange};
  keep_distinct(polygon, flat);
  if (flat.ring_ends.empty()) return {PolygonOutcome::kNoArea};
  double perimeter = 0;
  for (std::uint32_t i = 0; i < flat.ring_ends.front(); ++i)
    perimeter += glm::distance(polygon.points[flat.source[i]],
                               polygon.points[flat.source[i + 1 < flat.ring_ends.front() ? i + 1 : 0]]);
  const auto is_flat = [&](const glm::dvec3& n) { return !(glm::length(n) > kFlat * perimeter * perimeter); };
  glm::dvec3 normal = newell_normal(polygon);
  const bool is_balanced = is_flat(normal);
  if (is_balanced) normal = widest_normal(polygon, flat);
  if (is_flat(normal)) return {perimeter > kMaxPerimeterM ? PolygonOutcome::kOutOfRange : PolygonOutcome::kNoArea};
  if (flat.source.size() == 3) {
    out.push_back({flat.source[0], flat.source[1], flat.source[2]});
    return {};
  }
  project(polygon, normal, flat);
  if (flat.source.size() == 4 && cut_convex_quad(polygon, flat, out)) return {};

  const auto holes = static_cast<std::uint32_t>(flat.ring_ends.size() - 1);
  Triangles local;
  const auto keep = [&] {
    for (const auto& t : local) out.push_back({flat.source[t[0]], flat.source[t[1]], flat.source[t[2]]});
  };
  if (!is_balanced && triangulate_rings(flat.points, flat.ring_ends, local) && covers(flat, local) && !local.empty()) {
    keep();
    return {};
  }
  local.clear();
  if (const auto filled = holes > 0 ? cut_sound_rings(flat, local) : std::nullopt) {
    keep();
    return {local.empty() ? PolygonOutcome::kCovered : PolygonOutcome::kTriangulated, *filled};
  }
  if (cut_loops(polygon, flat, out)) return {PolygonOutcome::kSelfCrossing, holes};
  if (is_balanced) return {PolygonOutcome::kNoArea};  // to and fro on the same lines
  clip_ears(flat, out);
  return {PolygonOutcome::kTangled, holes};
}

}  // namespace zc
