// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/appearance/texture_source.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <limits>
#include <utility>

namespace zc {
namespace {

constexpr std::size_t kBlockTriangles = 64;
// Morton cells, in steps of the lattice: what lies closer has no order of its own.
constexpr unsigned kMortonShift = 9;

std::uint64_t spread(std::uint64_t x) {
  x &= 0x1FFFFF;
  x = (x | x << 32U) & 0x1F00000000FFFFULL;
  x = (x | x << 16U) & 0x1F0000FF0000FFULL;
  x = (x | x << 8U) & 0x100F00F00F00F00FULL;
  x = (x | x << 4U) & 0x10C30C30C30C30C3ULL;
  return (x | x << 2U) & 0x1249249249249249ULL;
}

std::uint64_t morton(const SourceTriangle& t) {
  const glm::dvec3 center = (t.p[0] + t.p[1] + t.p[2]) / 3.0;
  std::uint64_t code = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double cell = std::clamp(center[axis], 0.0, static_cast<double>(kLatticeExtentMax));
    code |= spread(static_cast<std::uint64_t>(cell) >> kMortonShift) << axis;
  }
  return code;
}

}  // namespace

TextureSource::TextureSource(Scene& scene, const WorldLattice& lattice) : images_(std::move(scene.images)) {
  const double steps_per_m = std::ldexp(1.0, -lattice.step_log2);
  const glm::dvec3 anchor(lattice.anchor[0], lattice.anchor[1], lattice.anchor[2]);
  const auto to_steps = [&](std::uint32_t v) { return scene.positions[v] * steps_per_m - anchor; };
  triangles_.reserve(scene.texcoords.size());
  for (const TriangleTexcoords& entry : scene.texcoords) {
    const auto& corners = scene.triangles[entry.triangle];
    triangles_.push_back({{to_steps(corners[0]), to_steps(corners[1]), to_steps(corners[2])},
                          entry.uv,
                          scene.triangle_material[entry.triangle]});
  }
  scene.texcoords = {};
  sort();
}

// And boxes of blocks of neighbours.
void TextureSource::sort() {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order(triangles_.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = {morton(triangles_[i]), i};
  std::sort(order.begin(), order.end());
  std::vector<SourceTriangle> sorted;
  sorted.reserve(order.size());
  for (const auto& [code, index] : order) sorted.push_back(triangles_[index]);
  triangles_ = std::move(sorted);
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    if (i % kBlockTriangles == 0)
      blocks_.push_back(
          {glm::dvec3(std::numeric_limits<double>::max()), glm::dvec3(std::numeric_limits<double>::lowest())});
    for (const glm::dvec3& p : triangles_[i].p) {
      blocks_.back().min = glm::min(blocks_.back().min, p);
      blocks_.back().max = glm::max(blocks_.back().max, p);
    }
  }
}

std::vector<const SourceTriangle*> TextureSource::within(const glm::dvec3& min, const glm::dvec3& max) const {
  const auto apart = [&](const glm::dvec3& low, const glm::dvec3& high) {
    return low.x > max.x || low.y > max.y || low.z > max.z || high.x < min.x || high.y < min.y || high.z < min.z;
  };
  std::vector<const SourceTriangle*> found;
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    if (apart(blocks_[b].min, blocks_[b].max)) continue;
    const std::size_t end = std::min(triangles_.size(), (b + 1) * kBlockTriangles);
    for (std::size_t i = b * kBlockTriangles; i < end; ++i) {
      const auto& p = triangles_[i].p;
      if (!apart(glm::min(glm::min(p[0], p[1]), p[2]), glm::max(glm::max(p[0], p[1]), p[2])))
        found.push_back(&triangles_[i]);
    }
  }
  return found;
}

}  // namespace zc
