// SPDX-License-Identifier: Apache-2.0
#include "replay/bench/oracle.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>
#include <numeric>
#include <utility>

#include "replay/bench/engines/parallel_chunks.h"

namespace zc::bench {
namespace {

constexpr std::uint32_t kLeafTriangles = 4;
constexpr std::size_t kRing = 16;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

OracleRay widen(const BenchRay& ray) { return {{ray.ox, ray.oy, ray.oz}, {ray.dx, ray.dy, ray.dz}}; }

// Where the ray enters the box, or infinity. The slack covers the rounding of the three products, many times over.
double enter(const glm::dvec3& min, const glm::dvec3& max, const glm::dvec3& origin, const glm::dvec3& reciprocal) {
  double near = 0;
  double far = kInfinity;
  for (int axis = 0; axis < 3; ++axis) {
    double t0 = (min[axis] - origin[axis]) * reciprocal[axis];
    double t1 = (max[axis] - origin[axis]) * reciprocal[axis];
    if (t0 > t1) std::swap(t0, t1);
    near = std::max(near, t0);
    far = std::min(far, t1);
  }
  return near * (1 - 1e-12) <= far * (1 + 1e-12) ? near * (1 - 1e-12) : kInfinity;
}

double rounding_bound(const glm::dvec3& origin, const std::array<glm::dvec3, 3>& corners) {
  double farthest = 0;
  for (const glm::dvec3& corner : corners) farthest = std::max(farthest, glm::distance(origin, corner));
  return kRoundings * 0x1p-24 * farthest;
}

// The least t in [0, t_at] from which on the ray stays within `reach` of the triangle until t_at, where it is within.
// The distance to a convex set is convex along a line, so bisection finds it.
double first_within(const OracleRay& ray, const std::array<glm::dvec3, 3>& corners, double t_at, double reach) {
  const double diameter = std::max({glm::distance(corners[0], corners[1]), glm::distance(corners[1], corners[2]),
                                    glm::distance(corners[2], corners[0])});
  const auto within = [&](double t) { return distance_to_triangle(ray.origin + t * ray.direction, corners) <= reach; };
  double low = std::max(0.0, t_at - 2 * diameter - 4 * reach);
  if (within(low)) return low;
  double high = t_at;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (within(middle) ? high : low) = middle;
  }
  return high;
}

// The ray, and a ring of others at `radius` around it.
std::array<OracleRay, kRing + 1> bundle(const OracleRay& ray, double radius) {
  const glm::dvec3 d = glm::normalize(ray.direction);
  const glm::dvec3 side = std::abs(d.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 a = glm::normalize(glm::cross(d, side));
  const glm::dvec3 b = glm::cross(d, a);
  std::array<OracleRay, kRing + 1> rays;
  rays.fill(ray);
  for (std::size_t i = 0; i < kRing; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / kRing;
    rays[i + 1].origin += radius * (std::cos(angle) * a + std::sin(angle) * b);
  }
  return rays;
}

// Whether the ray and all of the ring at `radius` around it are stopped nearer than t_limit.
bool stopped_for_certain(const Oracle& oracle, const OracleRay& ray, double t_limit, double radius) {
  return std::ranges::all_of(bundle(ray, radius),
                             [&](const OracleRay& r) { return oracle.trace(r, radius).t < t_limit; });
}

// Whether nothing that the oracle knows of comes within `radius` of the ray. Rings of several widths, so that no sliver
// lies between them unseen.
bool passes_for_certain(const Oracle& oracle, const OracleRay& ray, double radius) {
  for (const double share : {1.0, 0.25, 0.0625})
    for (const OracleRay& r : bundle(ray, share * radius))
      if (oracle.trace(r).triangle != kMiss) return false;
  return true;
}

Verdict judge_miss(const Oracle& oracle, const OracleRay& ray, const OracleHit& expected) {
  if (expected.triangle == kMiss) return Verdict::kMissedByBoth;
  const double bound = rounding_bound(ray.origin, oracle.corners(expected.triangle));
  return stopped_for_certain(oracle, ray, kInfinity, 2 * bound) ? Verdict::kMismatch : Verdict::kTied;
}

}  // namespace

double intersect(const OracleRay& ray, const std::array<glm::dvec3, 3>& corners) {
  const glm::dvec3 a = corners[0] - ray.origin;
  const glm::dvec3 b = corners[1] - ray.origin;
  const glm::dvec3 c = corners[2] - ray.origin;
  const double u = glm::dot(ray.direction, glm::cross(c, b));
  const double v = glm::dot(ray.direction, glm::cross(a, c));
  const double w = glm::dot(ray.direction, glm::cross(b, a));
  if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return kInfinity;
  const glm::dvec3 n = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
  const double facing = glm::dot(n, ray.direction);
  if (facing == 0) return kInfinity;
  return glm::dot(n, a) / facing;
}

// The point's region among the triangle's corners, edges and inside (Ericson 2005, section 5.1.5).
double distance_to_triangle(const glm::dvec3& point, const std::array<glm::dvec3, 3>& corners) {
  const auto to_edge = [&](const glm::dvec3& from, const glm::dvec3& to) {
    const glm::dvec3 along = to - from;
    const double t = std::clamp(glm::dot(point - from, along) / glm::dot(along, along), 0.0, 1.0);
    return glm::distance(point, from + t * along);
  };
  const auto& [a, b, c] = corners;
  const glm::dvec3 n = glm::cross(b - a, c - a);
  const bool inside = glm::dot(glm::cross(b - a, point - a), n) >= 0 &&
                      glm::dot(glm::cross(c - b, point - b), n) >= 0 && glm::dot(glm::cross(a - c, point - c), n) >= 0;
  if (inside) return std::abs(glm::dot(point - a, n)) / glm::length(n);
  return std::min({to_edge(a, b), to_edge(b, c), to_edge(c, a)});
}

Oracle::Oracle(std::span<const BenchTriangle> triangles) : triangles_(triangles) {
  order_.resize(triangles.size());
  std::iota(order_.begin(), order_.end(), 0U);
  std::vector<glm::dvec3> centers(triangles.size());
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    const auto p = corners(i);
    centers[i] = (glm::min(p[0], glm::min(p[1], p[2])) + glm::max(p[0], glm::max(p[1], p[2]))) * 0.5;
  }
  nodes_.emplace_back();
  build(0, 0, static_cast<std::uint32_t>(triangles.size()), centers);
}

// Median splits on the axis in which the centres spread widest: nothing that could be wrong in the way that an engine's
// builder could.
void Oracle::build(std::uint32_t node, std::uint32_t first, std::uint32_t count, std::span<const glm::dvec3> centers) {
  glm::dvec3 min(kInfinity), max(-kInfinity), low(kInfinity), high(-kInfinity);
  for (std::uint32_t i = first; i < first + count; ++i) {
    for (const glm::dvec3& p : corners(order_[i])) {
      min = glm::min(min, p);
      max = glm::max(max, p);
    }
    low = glm::min(low, centers[order_[i]]);
    high = glm::max(high, centers[order_[i]]);
  }
  const glm::dvec3 pad = 1e-12 * glm::max(glm::abs(min), glm::abs(max)) + 1e-12;
  nodes_[node].min = min - pad;
  nodes_[node].max = max + pad;
  nodes_[node].first = first;
  nodes_[node].count = count;
  if (count <= kLeafTriangles) return;
  const glm::dvec3 spread = high - low;
  const int axis = spread.x >= spread.y && spread.x >= spread.z ? 0 : (spread.y >= spread.z ? 1 : 2);
  const auto begin = order_.begin() + first;
  const std::uint32_t half = count / 2;
  std::nth_element(begin, begin + half, begin + count, [&](std::uint32_t a, std::uint32_t b) {
    return centers[a][axis] != centers[b][axis] ? centers[a][axis] < centers[b][axis] : a < b;
  });
  const auto children = static_cast<std::uint32_t>(nodes_.size());
  nodes_.resize(nodes_.size() + 2);
  nodes_[node].first = children;
  nodes_[node].count = 0;
  build(children, first, half, centers);
  build(children + 1, first + half, count - half, centers);
}

std::array<glm::dvec3, 3> Oracle::corners(std::uint32_t triangle) const {
  const auto& v = triangles_[triangle].v;
  return {glm::dvec3(v[0], v[1], v[2]), glm::dvec3(v[3], v[4], v[5]), glm::dvec3(v[6], v[7], v[8])};
}

OracleHit Oracle::trace(const OracleRay& ray, double clear_m) const {
  OracleHit hit;
  if (triangles_.empty()) return hit;
  glm::dvec3 reciprocal;
  for (int axis = 0; axis < 3; ++axis)
    reciprocal[axis] = std::copysign(1 / std::max(std::abs(ray.direction[axis]), 1e-300), ray.direction[axis]);
  std::array<std::pair<double, std::uint32_t>, 64> stack;  // median splits: depth is the logarithm of the count
  std::size_t size = 0;
  stack[size++] = {enter(nodes_[0].min, nodes_[0].max, ray.origin, reciprocal), 0};
  while (size > 0) {
    const auto [near, at] = stack[--size];
    if (near > hit.t || near == kInfinity) continue;
    const Node& node = nodes_[at];
    if (node.count == 0) {
      std::pair<double, std::uint32_t> a{0, node.first};
      std::pair<double, std::uint32_t> b{0, node.first + 1};
      for (auto* child : {&a, &b})
        child->first = enter(nodes_[child->second].min, nodes_[child->second].max, ray.origin, reciprocal);
      if (a.first < b.first) std::swap(a, b);
      stack[size++] = a;
      stack[size++] = b;
      continue;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      const std::uint32_t triangle = order_[i];
      const auto p = corners(triangle);
      const double t = intersect(ray, p);
      if (!(t >= 0) || t > hit.t || t == kInfinity || (t == hit.t && triangle > hit.triangle)) continue;
      if (clear_m >= 0 && distance_to_triangle(ray.origin, p) <= clear_m) continue;
      hit = {t, triangle};
    }
  }
  return hit;
}

double Oracle::farthest_m(const glm::dvec3& point) const {
  return glm::length(glm::max(glm::abs(nodes_[0].min - point), glm::abs(nodes_[0].max - point)));
}

std::vector<OracleHit> Oracle::trace(std::span<const BenchRay> rays, unsigned threads) const {
  std::vector<OracleHit> hits(rays.size());
  parallel_chunks(rays.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) hits[i] = trace(widen(rays[i]));
  });
  return hits;
}

Verdict judge(const Oracle& oracle, const BenchRay& float_ray, const OracleHit& expected, const BenchHit& reported,
              std::size_t triangle_count) {
  const OracleRay ray = widen(float_ray);
  if (reported.triangle == kMiss) return judge_miss(oracle, ray, expected);
  if (reported.triangle >= triangle_count || !(reported.t >= 0) || !std::isfinite(reported.t))
    return Verdict::kMismatch;
  const double t = static_cast<double>(reported.t);
  const auto corners = oracle.corners(reported.triangle);
  const double bound = rounding_bound(ray.origin, corners);
  if (distance_to_triangle(ray.origin + t * ray.direction, corners) > bound) return Verdict::kMismatch;
  if (reported.triangle == expected.triangle) return Verdict::kSame;
  if (expected.t >= t) return Verdict::kTied;
  const double radius = 2 * std::max(bound, rounding_bound(ray.origin, oracle.corners(expected.triangle)));
  const double t_limit = first_within(ray, corners, t, radius);
  if (expected.t >= t_limit) return Verdict::kTied;
  return stopped_for_certain(oracle, ray, t_limit, radius) ? Verdict::kMismatch : Verdict::kTied;
}

Verdict judge_any_hit(const Oracle& oracle, const BenchRay& float_ray, const OracleHit& expected,
                      const BenchHit& reported, std::size_t triangle_count) {
  const OracleRay ray = widen(float_ray);
  if (reported.triangle == kMiss) return judge_miss(oracle, ray, expected);
  if (reported.triangle >= triangle_count) return Verdict::kMismatch;
  if (expected.triangle != kMiss) return Verdict::kSame;
  const double bound = kRoundings * 0x1p-24 * oracle.farthest_m(ray.origin);
  return passes_for_certain(oracle, ray, 2 * bound) ? Verdict::kMismatch : Verdict::kTied;
}

Comparison compare(const Oracle& oracle, std::span<const BenchRay> rays, std::span<const OracleHit> expected,
                   std::span<const BenchHit> reported, std::size_t triangle_count, bool any_hit, unsigned threads) {
  std::vector<Verdict> verdicts(rays.size());
  parallel_chunks(rays.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      verdicts[i] = (any_hit ? judge_any_hit : judge)(oracle, rays[i], expected[i], reported[i], triangle_count);
  });
  Comparison sum;
  for (std::size_t i = 0; i < verdicts.size(); ++i) {
    switch (verdicts[i]) {
      case Verdict::kSame:
        ++sum.same;
        break;
      case Verdict::kTied:
        ++sum.tied;
        break;
      case Verdict::kMissedByBoth:
        ++sum.missed_by_both;
        break;
      case Verdict::kMismatch:
        if (sum.mismatches++ == 0) sum.first_mismatch = i;
        break;
    }
  }
  return sum;
}

}  // namespace zc::bench
