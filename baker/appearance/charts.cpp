// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/appearance/charts.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace zc {
namespace {

// A chart's normals lie within this of its first triangle's: texels of one chart are about as wide as each other.
constexpr double kSpreadCosine = 0.9;

using Corner = std::array<std::uint16_t, 3>;

struct EdgeSide {
  Corner low;
  Corner high;
  std::uint32_t triangle = 0;

  [[nodiscard]] bool same_edge(const EdgeSide& o) const { return low == o.low && high == o.high; }
  bool operator<(const EdgeSide& o) const {
    if (low != o.low) return low < o.low;
    return high != o.high ? high < o.high : triangle < o.triangle;
  }
};

class ChartCutter {
 public:
  ChartCutter(const ZoneMesh& mesh, const std::vector<bool>& textured)
      : mesh_(mesh), textured_(textured), normal_(mesh.triangles.size()), neighbours_(mesh.triangles.size()) {
    std::vector<EdgeSide> sides;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      if (!textured[t]) continue;
      const auto& [a, b, c] = mesh.triangles[t];
      normal_[t] = glm::cross(point(b) - point(a), point(c) - point(a));
      if (const double length = glm::length(normal_[t]); length > 0) normal_[t] /= length;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto [low, high] = std::minmax(corner(t, k), corner(t, (k + 1) % 3));
        sides.push_back({low, high, t});
      }
    }
    std::sort(sides.begin(), sides.end());
    for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
      while (end < sides.size() && sides[end].same_edge(sides[begin])) ++end;
      for (std::size_t i = begin; i < end; ++i)
        for (std::size_t j = begin; j < end && end - begin <= kMaxFan; ++j)
          if (i != j) neighbours_[sides[i].triangle].push_back(sides[j].triangle);
    }
  }

  std::vector<Chart> run() {
    std::vector<Chart> charts;
    taken_.assign(mesh_.triangles.size(), false);
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t)
      if (textured_[t] && !taken_[t]) charts.push_back(grow(t));
    return charts;
  }

 private:
  // More triangles at one edge are no surface.
  static constexpr std::size_t kMaxFan = 8;

  [[nodiscard]] glm::dvec3 point(std::uint32_t v) const {
    const Corner& q = mesh_.vertices[v];
    return {q[0], q[1], q[2]};
  }
  [[nodiscard]] const Corner& corner(std::uint32_t t, std::size_t k) const {
    return mesh_.vertices[mesh_.triangles[t][k]];
  }

  Chart grow(std::uint32_t seed) {
    Chart chart;
    const glm::dvec3 along = normal_[seed];
    for (std::uint32_t axis = 1; axis < 3; ++axis)
      if (std::abs(along[static_cast<int>(axis)]) > std::abs(along[static_cast<int>(chart.axis)])) chart.axis = axis;
    chart.facing = along[static_cast<int>(chart.axis)] < 0 ? -1 : 1;
    chart.triangles = {seed};
    taken_[seed] = true;
    for (std::size_t i = 0; i < chart.triangles.size(); ++i) {
      for (const std::uint32_t next : neighbours_[chart.triangles[i]]) {
        if (taken_[next] || glm::dot(normal_[next], along) < kSpreadCosine) continue;
        taken_[next] = true;
        chart.triangles.push_back(next);
      }
    }
    const std::array<int, 2> plane = {chart.u(), chart.v()};
    chart.min = {INT32_MAX, INT32_MAX};
    chart.max = {INT32_MIN, INT32_MIN};
    for (const std::uint32_t t : chart.triangles)
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t i = 0; i < 2; ++i) {
          const std::int32_t q = corner(t, k)[static_cast<std::size_t>(plane[i])];
          chart.min[i] = std::min(chart.min[i], q);
          chart.max[i] = std::max(chart.max[i], q);
        }
    return chart;
  }

  const ZoneMesh& mesh_;
  const std::vector<bool>& textured_;
  std::vector<glm::dvec3> normal_;
  std::vector<std::vector<std::uint32_t>> neighbours_;
  std::vector<bool> taken_;
};

}  // namespace

std::vector<Chart> cut_charts(const ZoneMesh& mesh, const std::vector<bool>& textured) {
  return ChartCutter(mesh, textured).run();
}

}  // namespace zc
