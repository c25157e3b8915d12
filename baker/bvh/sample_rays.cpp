// SPDX-License-Identifier: GPL-3.0-or-later
// The representative rays of simulate.h.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "baker/bvh/simulate.h"
#include "base/check.h"

namespace zc {
namespace {

using Vector = std::array<double, 3>;

constexpr double kViewSlope = 20.0 / 180.0 * std::numbers::pi;

// Points of the unit cube of four dimensions; 1.1673 is the root of x^5 = x + 1.
class Sequence {
 public:
  Vector next3() { return {next(0), next(1), next(2)}; }
  double fourth() { return next(3); }
  void advance() { ++index_; }

 private:
  [[nodiscard]] double next(int dimension) const {
    const double step = std::pow(1.0 / 1.1673039782614187, dimension + 1);
    const double value = 0.5 + step * static_cast<double>(index_);
    return value - std::floor(value);
  }
  std::uint32_t index_ = 1;
};

Vector corner(const BvhTriangle& t, std::size_t i) {
  return {static_cast<double>(t[i][0]), static_cast<double>(t[i][1]), static_cast<double>(t[i][2])};
}

// Twice the area long.
Vector normal_of(const BvhTriangle& t) {
  const Vector a = corner(t, 0);
  Vector u = corner(t, 1);
  Vector v = corner(t, 2);
  for (std::size_t i = 0; i < 3; ++i) {
    u[i] -= a[i];
    v[i] -= a[i];
  }
  return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
}

double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

class Sampler {
 public:
  explicit Sampler(std::span<const BvhTriangle> triangles) : triangles_(triangles), sums_(triangles.size()) {
    double sum = 0;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      const Vector n = normal_of(triangles[i]);
      sum += std::sqrt(dot(n, n));
      sums_[i] = sum;
      bounds_.add(box_of(triangles[i]));
    }
  }

  // A mirror ray of a view; half a unit off its surface.
  SampleRay mirror(double pick, double place, double turn, double tilt) const {
    const auto at = std::ranges::upper_bound(sums_, pick * sums_.back()) - sums_.begin();
    const BvhTriangle& t = triangles_[std::min(static_cast<std::size_t>(at), triangles_.size() - 1)];
    Vector n = normal_of(t);
    const double length = std::sqrt(dot(n, n));
    n = length > 0 ? Vector{n[0] / length, n[1] / length, n[2] / length} : Vector{0, 0, 1};
    // `pick` within the triangle's own share serves as the second coordinate of the place on it.
    const double before = at > 0 ? sums_[static_cast<std::size_t>(at) - 1] : 0;
    const double within = length > 0 ? std::clamp((pick * sums_.back() - before) / length, 0.0, 1.0) : 0;
    const double root = std::sqrt(place);
    const Vector a = corner(t, 0);
    const Vector b = corner(t, 1);
    const Vector c = corner(t, 2);
    const double angle = 2 * std::numbers::pi * turn;
    const double slope = (2 * tilt - 1) * kViewSlope;
    const Vector view = {std::cos(angle) * std::cos(slope), std::sin(angle) * std::cos(slope), std::sin(slope)};
    const double along = dot(view, n);
    SampleRay ray{};
    for (std::size_t i = 0; i < 3; ++i) {
      const double point = (1 - root) * a[i] + root * (1 - within) * b[i] + root * within * c[i];
      ray.origin[i] = static_cast<float>(point + (along > 0 ? -0.5 : 0.5) * n[i]);
      ray.direction[i] = static_cast<float>(view[i] - 2 * along * n[i]);
    }
    return ray;
  }

  // From outside of the box through the point at `place` of it.
  [[nodiscard]] SampleRay enter(const Vector& place, SampleRay ray) const {
    double span = 1;
    for (std::size_t i = 0; i < 3; ++i) span += bounds_.max[i] - bounds_.min[i];
    for (std::size_t i = 0; i < 3; ++i) {
      const double point = bounds_.min[i] + place[i] * (bounds_.max[i] - bounds_.min[i]);
      ray.origin[i] = static_cast<float>(point - span * static_cast<double>(ray.direction[i]));
    }
    return ray;
  }

 private:
  std::span<const BvhTriangle> triangles_;
  std::vector<double> sums_;  // of areas, doubled
  BvhBox bounds_;
};

}  // namespace

std::vector<SampleRay> make_sample_rays(std::span<const BvhTriangle> triangles, std::uint32_t count) {
  ZC_CHECK(!triangles.empty());
  const Sampler sampler(triangles);
  Sequence sequence;
  std::vector<SampleRay> rays(count);
  for (std::uint32_t i = 0; i < count; ++i, sequence.advance()) {
    const Vector u = sequence.next3();
    rays[i] = sampler.mirror(u[0], u[1], u[2], sequence.fourth());
    if (i % 2 == 1) {
      sequence.advance();
      rays[i] = sampler.enter(sequence.next3(), rays[i]);
    }
  }
  return rays;
}

}  // namespace zc
