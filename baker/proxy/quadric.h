// SPDX-License-Identifier: GPL-3.0-or-later
// Sum of weighted squared distances to planes. Source: Garland & Heckbert 1997. Thread-safe: plain values.
#pragma once

#include <algorithm>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace zc {

struct Quadric {
  glm::dmat3 a{0.0};
  glm::dvec3 b{0.0};
  double c = 0;

  // The plane through `point` with unit normal `n`.
  void add_plane(const glm::dvec3& n, const glm::dvec3& point, double weight) {
    const double d = -glm::dot(n, point);
    a += glm::outerProduct(n, n) * weight;
    b += n * (d * weight);
    c += d * d * weight;
  }
  Quadric& operator+=(const Quadric& other) {
    a += other.a;
    b += other.b;
    c += other.c;
    return *this;
  }
  [[nodiscard]] double at(const glm::dvec3& p) const {
    return std::max(0.0, glm::dot(p, a * p) + 2 * glm::dot(b, p) + c);
  }
};

}  // namespace zc
