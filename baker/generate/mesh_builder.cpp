// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/generate/mesh_builder.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <utility>

#include "base/check.h"

namespace zc::generate {
namespace {

constexpr double kGrid = 1024;  // steps in a metre
constexpr double kTurn = 6.283185307179586;

double cross(Vec2 a, Vec2 b) { return a.x * b.y - a.y * b.x; }

// The share of the chain's length at which each vertex stands.
std::vector<double> shares(std::span<const Vec3> chain) {
  std::vector<double> share = {0};
  for (std::size_t i = 1; i < chain.size(); ++i) share.push_back(share.back() + glm::distance(chain[i - 1], chain[i]));
  for (double& s : share) s /= share.back();
  return share;
}

bool inside(Vec2 p, Vec2 a, Vec2 b, Vec2 c) {
  return cross(b - a, p - a) >= 0 && cross(c - b, p - b) >= 0 && cross(a - c, p - c) >= 0;
}

// Two unit vectors that complete `axis` to a right-handed frame (u, v, axis).
std::pair<Vec3, Vec3> frame_around(Vec3 axis) {
  const Vec3 side = std::abs(axis.z) < 0.9 ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
  const Vec3 u = glm::normalize(glm::cross(side, axis));
  return {u, glm::cross(axis, u)};
}

}  // namespace

Polygon inset_polygon(std::span<const Vec2> outline, double by) {
  Polygon out;
  const std::size_t n = outline.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 before = glm::normalize(outline[i] - outline[(i + n - 1) % n]);
    const Vec2 after = glm::normalize(outline[(i + 1) % n] - outline[i]);
    const Vec2 n0 = {-before.y, before.x};
    const Vec2 n1 = {-after.y, after.x};
    out.push_back(outline[i] + (n0 + n1) * (by / (1 + glm::dot(n0, n1))));
  }
  return out;
}

Polygon circle(Vec2 center, double radius, int sides, double turn) {
  Polygon out;
  for (int i = 0; i < sides; ++i) {
    const double angle = turn + kTurn * i / sides;
    out.push_back(center + radius * Vec2{std::cos(angle), std::sin(angle)});
  }
  return out;
}

void MeshBuilder::set_frame(Vec3 origin, Vec2 heading) {
  origin_ = origin;
  heading_ = heading;
}

Vec3 MeshBuilder::place(Vec3 local) const {
  const Vec3 world =
      origin_ + Vec3{local.x * heading_.x - local.y * heading_.y, local.x * heading_.y + local.y * heading_.x, local.z};
  return {std::round(world.x * kGrid) / kGrid, std::round(world.y * kGrid) / kGrid,
          std::round(world.z * kGrid) / kGrid};
}

void MeshBuilder::triangle(Vec3 a, Vec3 b, Vec3 c, Mat m) {
  const MeshTriangle t = {{place(a), place(b), place(c)}, m};
  if (t.corners[0] == t.corners[1] || t.corners[1] == t.corners[2] || t.corners[2] == t.corners[0]) return;
  triangles_.push_back(t);
}

void MeshBuilder::quad(Vec3 a, Vec3 b, Vec3 c, Vec3 d, Mat m) {
  triangle(a, b, c, m);
  triangle(a, c, d, m);
}

void MeshBuilder::strip(std::span<const Vec3> low, std::span<const Vec3> high, Mat m) {
  const std::vector<double> s = shares(low);
  const std::vector<double> t = shares(high);
  std::size_t i = 0;
  std::size_t j = 0;
  while (i + 1 < low.size() || j + 1 < high.size()) {
    const bool advance_low = j + 1 == high.size() || (i + 1 < low.size() && s[i + 1] <= t[j + 1]);
    if (advance_low) {
      triangle(low[i], low[i + 1], high[j], m);
      ++i;
    } else {
      triangle(low[i], high[j + 1], high[j], m);
      ++j;
    }
  }
}

void MeshBuilder::cap(std::span<const Vec2> outline, double z, Mat m, bool up) {
  std::vector<std::size_t> left(outline.size());
  for (std::size_t i = 0; i < left.size(); ++i) left[i] = i;
  const auto emit = [&](std::size_t a, std::size_t b, std::size_t c) {
    const Vec3 pa{outline[a], z};
    const Vec3 pb{outline[b], z};
    const Vec3 pc{outline[c], z};
    if (up) {
      triangle(pa, pb, pc, m);
    } else {
      triangle(pa, pc, pb, m);
    }
  };
  while (left.size() > 3) {
    const std::size_t n = left.size();
    // The ear with the largest smallest height, so that caps are not needles.
    std::size_t best = n;
    double best_quality = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const Vec2 a = outline[left[(i + n - 1) % n]];
      const Vec2 b = outline[left[i]];
      const Vec2 c = outline[left[(i + 1) % n]];
      const double area = cross(b - a, c - b);
      if (area <= 1e-9) continue;
      bool empty = true;
      for (std::size_t k = 0; k < n && empty; ++k) {
        const Vec2 p = outline[left[k]];
        if (p != a && p != b && p != c && inside(p, a, b, c)) empty = false;
      }
      const double longest = std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
      if (empty && area / longest > best_quality) {
        best = i;
        best_quality = area / longest;
      }
    }
    ZC_CHECK(best < n);
    emit(left[(best + n - 1) % n], left[best], left[(best + 1) % n]);
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(best));
  }
  emit(left[0], left[1], left[2]);
}

void MeshBuilder::ring(std::span<const Vec2> outer, std::span<const Vec2> hole, double z, Mat m) {
  // Cut the ring open between outer[0] and the hole's vertex furthest in its direction: nothing lies between the two.
  Vec2 center = {0, 0};
  for (const Vec2 p : hole) center += p / static_cast<double>(hole.size());
  const Vec2 towards = outer[0] - center;
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < hole.size(); ++i) {
    if (glm::dot(hole[i], towards) > glm::dot(hole[nearest], towards)) nearest = i;
  }
  Polygon slit(outer.begin(), outer.end());
  slit.push_back(outer[0]);
  for (std::size_t k = 0; k <= hole.size(); ++k) slit.push_back(hole[(nearest + hole.size() - k) % hole.size()]);
  cap(slit, z, m);
}

void MeshBuilder::walls(std::span<const Vec2> outline, double z0, double z1, Mat m, bool outward) {
  for (std::size_t i = 0; i < outline.size(); ++i) {
    Vec2 a = outline[i];
    Vec2 b = outline[(i + 1) % outline.size()];
    if (!outward) std::swap(a, b);
    quad({a, z0}, {b, z0}, {b, z1}, {a, z1}, m);
  }
}

void MeshBuilder::prism(std::span<const Vec2> outline, double z0, double z1, Mat side, Mat top) {
  walls(outline, z0, z1, side);
  cap(outline, z1, top);
  cap(outline, z0, side, false);
}

void MeshBuilder::box(Vec3 low, Vec3 high, Mat side, Mat top) {
  prism(Rect{low.x, low.y, high.x, high.y}.polygon(), low.z, high.z, side, top);
}

void MeshBuilder::tube(Vec3 from, Vec3 to, double radius_from, double radius_to, int sides, Mat m) {
  const auto [u, v] = frame_around(glm::normalize(to - from));
  const auto at = [&, u = u, v = v](Vec3 center, double radius, int i) {
    const double angle = kTurn * (i % sides) / sides;
    return center + radius * (std::cos(angle) * u + std::sin(angle) * v);
  };
  for (int i = 0; i < sides; ++i) {
    quad(at(from, radius_from, i), at(from, radius_from, i + 1), at(to, radius_to, i + 1), at(to, radius_to, i), m);
    if (i > 0 && i + 1 < sides) {
      triangle(at(from, radius_from, 0), at(from, radius_from, i + 1), at(from, radius_from, i), m);
      triangle(at(to, radius_to, 0), at(to, radius_to, i), at(to, radius_to, i + 1), m);
    }
  }
}

void MeshBuilder::torus(Vec3 center, Vec3 axis, double radius, double tube_radius, int segments, int sides, Mat m) {
  const auto [u, v] = frame_around(axis);
  const auto at = [&, u = u, v = v](int segment, int side) {
    const double around = kTurn * (segment % segments) / segments;
    const double across = kTurn * (side % sides) / sides;
    const Vec3 outward = std::cos(around) * u + std::sin(around) * v;
    return center + (radius + tube_radius * std::cos(across)) * outward + tube_radius * std::sin(across) * axis;
  };
  for (int i = 0; i < segments; ++i) {
    for (int k = 0; k < sides; ++k) quad(at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1), m);
  }
}

void MeshBuilder::blob(Vec3 center, Vec3 radii, bool fine, std::span<const double, 42> bumps, Mat m) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  std::vector<Vec3> points = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                              {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  std::vector<std::array<std::size_t, 3>> faces = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                                   {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                                   {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                                   {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  if (fine) {
    std::map<std::pair<std::size_t, std::size_t>, std::size_t> middles;
    const auto middle = [&](std::size_t a, std::size_t b) {
      const auto [it, fresh] = middles.try_emplace(std::minmax(a, b), points.size());
      if (fresh) points.push_back(points[a] + points[b]);
      return it->second;
    };
    std::vector<std::array<std::size_t, 3>> finer;
    for (const auto& [a, b, c] : faces) {
      const std::size_t ab = middle(a, b);
      const std::size_t bc = middle(b, c);
      const std::size_t ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    faces = std::move(finer);
  }
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = center + radii * glm::normalize(points[i]) * bumps[i];
  for (const auto& [a, b, c] : faces) triangle(points[a], points[b], points[c], m);
}

}  // namespace zc::generate
