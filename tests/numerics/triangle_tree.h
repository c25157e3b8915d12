// SPDX-License-Identifier: Apache-2.0
// Distances between meshes that share nothing with the baker's: another tree, another point-to-triangle formula, plain
// doubles.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <random>
#include <span>
#include <vector>

namespace zc::test {

using Triangle = std::array<glm::dvec3, 3>;

inline double distance_to_segment(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b) {
  const glm::dvec3 ab = b - a;
  const double length2 = glm::dot(ab, ab);
  const double t = length2 > 0 ? std::clamp(glm::dot(p - a, ab) / length2, 0.0, 1.0) : 0.0;
  return glm::distance(p, a + ab * t);
}

// The plane where the point is above the triangle, the nearest side elsewhere.
inline double distance_to_triangle(const glm::dvec3& p, const Triangle& t) {
  const double sides = std::min(
      {distance_to_segment(p, t[0], t[1]), distance_to_segment(p, t[1], t[2]), distance_to_segment(p, t[2], t[0])});
  const glm::dvec3 n = glm::cross(t[1] - t[0], t[2] - t[0]);
  const double length = glm::length(n);
  if (length == 0) return sides;
  for (std::size_t i = 0; i < 3; ++i)
    if (glm::dot(glm::cross(t[(i + 1) % 3] - t[i], p - t[i]), n) < 0) return sides;
  return std::min(sides, std::abs(glm::dot(p - t[0], n)) / length);
}

// Triangles in halves of their boxes' centres.
class TriangleTree {
 public:
  explicit TriangleTree(std::vector<Triangle> triangles) : triangles_(std::move(triangles)) {
    if (!triangles_.empty()) build(0, triangles_.size());
  }

  // Of no consequence where it is no more than `enough`.
  [[nodiscard]] double distance(const glm::dvec3& p, double enough) const {
    double nearest = std::numeric_limits<double>::infinity();
    if (!nodes_.empty()) search(0, p, enough, nearest);
    return nearest;
  }
  [[nodiscard]] const std::vector<Triangle>& triangles() const { return triangles_; }

 private:
  struct Node {
    glm::dvec3 low, high;
    std::size_t first, count, right;
  };

  std::size_t build(std::size_t first, std::size_t count) {
    const std::size_t at = nodes_.size();
    nodes_.push_back({glm::dvec3(INFINITY), glm::dvec3(-INFINITY), first, count, 0});
    for (std::size_t i = first; i < first + count; ++i) {
      for (const glm::dvec3& p : triangles_[i]) {
        nodes_[at].low = glm::min(nodes_[at].low, p);
        nodes_[at].high = glm::max(nodes_[at].high, p);
      }
    }
    if (count <= 8) return at;
    const glm::dvec3 size = nodes_[at].high - nodes_[at].low;
    const int axis = size.x > size.y && size.x > size.z ? 0 : size.y > size.z ? 1 : 2;
    const auto begin = triangles_.begin() + static_cast<std::ptrdiff_t>(first);
    std::nth_element(begin, begin + static_cast<std::ptrdiff_t>(count / 2), begin + static_cast<std::ptrdiff_t>(count),
                     [&](const Triangle& a, const Triangle& b) {
                       return a[0][axis] + a[1][axis] + a[2][axis] < b[0][axis] + b[1][axis] + b[2][axis];
                     });
    build(first, count / 2);
    const std::size_t right = build(first + count / 2, count - count / 2);
    nodes_[at].right = right;
    return at;
  }

  [[nodiscard]] double box_distance(std::size_t i, const glm::dvec3& p) const {
    return glm::length(glm::max(glm::max(nodes_[i].low - p, p - nodes_[i].high), glm::dvec3(0)));
  }

  void search(std::size_t i, const glm::dvec3& p, double enough, double& nearest) const {
    const Node& node = nodes_[i];
    if (nearest <= enough || box_distance(i, p) >= nearest) return;
    if (node.right == 0) {
      for (std::size_t t = node.first; t < node.first + node.count; ++t)
        nearest = std::min(nearest, distance_to_triangle(p, triangles_[t]));
      return;
    }
    const bool left_first = box_distance(i + 1, p) <= box_distance(node.right, p);
    search(left_first ? i + 1 : node.right, p, enough, nearest);
    search(left_first ? node.right : i + 1, p, enough, nearest);
  }

  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
};

// Calls visit(point) at corners, along sides and at random inside, more where there is more area.
inline void sample(const Triangle& t, double area_per_sample, std::mt19937_64& random,
                   const std::function<void(const glm::dvec3&)>& visit) {
  constexpr std::array<double, 3> kAlong = {0, 0.37, 0.71};
  for (std::size_t i = 0; i < 3; ++i)
    for (const double s : kAlong) visit(t[i] + (t[(i + 1) % 3] - t[i]) * s);
  visit((t[0] + t[1] + t[2]) / 3.0);
  std::uniform_real_distribution<double> unit(0, 1);
  const double area = glm::length(glm::cross(t[1] - t[0], t[2] - t[0])) / 2;
  const auto count = static_cast<std::size_t>(std::min(area / area_per_sample, 1e5));
  for (std::size_t i = 0; i < count; ++i) {
    double u = unit(random);
    double v = unit(random);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    visit(t[0] + (t[1] - t[0]) * u + (t[2] - t[0]) * v);
  }
}

inline double area_of(std::span<const Triangle> triangles) {
  double area = 0;
  for (const Triangle& t : triangles) area += glm::length(glm::cross(t[1] - t[0], t[2] - t[0])) / 2;
  return area;
}

inline constexpr double kSamples = 30000;

inline double farthest(std::span<const Triangle> from, const TriangleTree& to) {
  std::mt19937_64 random(11);
  const double area_per_sample = std::max(area_of(from) / kSamples, 1e-9);
  double most = 0;
  for (const Triangle& t : from)
    sample(t, area_per_sample, random, [&](const glm::dvec3& p) { most = std::max(most, to.distance(p, most)); });
  return most;
}

}  // namespace zc::test
