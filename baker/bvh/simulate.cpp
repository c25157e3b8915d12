// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/bvh/simulate.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/check.h"

namespace zc {
namespace {

// Lattice units by which boxes grow, so that the float slab test loses no hit: coordinates and distances stay below
// 2^18 units, where a float's rounding is at most 2^-6.
constexpr float kPad = 0.125F;

float reciprocal(float d) { return std::copysign(1.0F / std::max(std::abs(d), 1e-18F), d); }

}  // namespace

TreeSimulation::TreeSimulation(const WideTree& tree, std::span<const BvhTriangle> triangles)
    : nodes_(tree.nodes.size()), tree_(&tree), triangles_(triangles) {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    Node& node = nodes_[i];
    for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
      const WideChild& child = tree.nodes[i].slots[slot];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const bool there = child.kind != WideChild::Kind::kNone;
        node.planes[axis][slot] = there ? static_cast<float>(child.box.min[axis]) - kPad : INFINITY;
        node.planes[axis + 3][slot] = there ? static_cast<float>(child.box.max[axis]) + kPad : -INFINITY;
      }
      if (child.kind == WideChild::Kind::kNode) {
        if (node.inner == 0) node.first_child = child.first;
        node.inner |= 1U << slot;
      } else if (child.kind == WideChild::Kind::kLeaf) {
        node.leaves |= 1U << slot;
        node.first_reference[slot] = child.first;
        node.count[slot] = static_cast<std::uint8_t>(child.count);
      }
    }
  }
}

void test_triangle(const BvhTriangle& triangle, std::uint32_t index, const SampleRay& ray, SampleHit& hit) {
  // Möller & Trumbore 1997.
  const auto edge = [&](std::size_t corner, std::size_t axis) {
    return static_cast<float>(triangle[corner][axis] - triangle[0][axis]);
  };
  const std::array<float, 3> a = {edge(1, 0), edge(1, 1), edge(1, 2)};
  const std::array<float, 3> b = {edge(2, 0), edge(2, 1), edge(2, 2)};
  const auto cross = [](const std::array<float, 3>& x, const std::array<float, 3>& y) {
    return std::array<float, 3>{x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]};
  };
  const auto dot = [](const std::array<float, 3>& x, const std::array<float, 3>& y) {
    return x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
  };
  const std::array<float, 3> p = cross(ray.direction, b);
  const float determinant = dot(a, p);
  if (determinant == 0) return;
  std::array<float, 3> from{};
  for (std::size_t axis = 0; axis < 3; ++axis) from[axis] = ray.origin[axis] - static_cast<float>(triangle[0][axis]);
  const float scale = 1 / determinant;
  const float u = dot(from, p) * scale;
  if (!(u >= 0 && u <= 1)) return;
  const std::array<float, 3> q = cross(from, a);
  const float v = dot(ray.direction, q) * scale;
  if (!(v >= 0 && u + v <= 1)) return;
  const float t = dot(b, q) * scale;
  if (t >= 0 && (t < hit.t || (t == hit.t && index < hit.triangle))) hit = {t, index};
}

SampleHit TreeSimulation::trace(const SampleRay& ray, TraceCounts& counts) const {
  std::array<float, 3> inverse{};
  std::uint32_t octant = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    inverse[axis] = reciprocal(ray.direction[axis]);
    if (ray.direction[axis] < 0) octant |= 1U << axis;
  }
  struct Group {
    std::uint32_t node;  // whose children these are
    std::uint32_t left;  // children that wait, bits by `slot ^ octant`
  };
  std::array<Group, gpu::kPageMaxDepth + 1> stack;
  std::size_t top = 0;
  SampleHit hit;
  std::uint32_t index = 0;
  for (;;) {
    const Node& node = nodes_[index];
    ++counts.nodes;
    std::array<float, gpu::kNodeWidth> enter;
    std::array<float, gpu::kNodeWidth> leave;
    enter.fill(0);
    leave.fill(hit.t);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const bool backward = (octant >> axis & 1U) != 0;
      const Planes& near = node.planes[backward ? axis + 3 : axis];
      const Planes& far = node.planes[backward ? axis : axis + 3];
      const float from = ray.origin[axis];
      const float scale = inverse[axis];
      for (std::size_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
        const float t0 = (near[slot] - from) * scale;
        const float t1 = (far[slot] - from) * scale;
        enter[slot] = t0 > enter[slot] ? t0 : enter[slot];
        leave[slot] = t1 < leave[slot] ? t1 : leave[slot];
      }
    }
    std::uint32_t hits = 0;
    for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot) hits |= (enter[slot] <= leave[slot] ? 1U : 0U) << slot;
    for (std::uint32_t leaves = hits & node.leaves; leaves != 0; leaves &= leaves - 1) {
      const auto slot = static_cast<std::uint32_t>(std::countr_zero(leaves));
      counts.triangles += node.count[slot];
      for (std::uint32_t k = 0; k < node.count[slot]; ++k) {
        const std::uint32_t triangle = tree_->references[node.first_reference[slot] + k].triangle;
        test_triangle(triangles_[triangle], triangle, ray, hit);
      }
    }
    if (const std::uint32_t inner = hits & node.inner; inner != 0) {
      std::uint32_t ordered = 0;
      for (std::uint32_t slots = inner; slots != 0; slots &= slots - 1)
        ordered |= 1U << (static_cast<std::uint32_t>(std::countr_zero(slots)) ^ octant);
      stack[top++] = {index, ordered};
    }
    if (top == 0) return hit;
    Group& group = stack[top - 1];
    const std::uint32_t slot = static_cast<std::uint32_t>(std::countr_zero(group.left)) ^ octant;
    const Node& above = nodes_[group.node];
    index = above.first_child + static_cast<std::uint32_t>(std::popcount(above.inner & ((1U << slot) - 1)));
    group.left &= group.left - 1;
    if (group.left == 0) --top;
  }
}

double mean_cost(const TraceCounts& counts, std::size_t rays) {
  ZC_CHECK(rays > 0);
  return (kNodeVisitCost * static_cast<double>(counts.nodes) +
          kTriangleTestCost * static_cast<double>(counts.triangles)) /
         static_cast<double>(rays);
}

double simulated_cost(const WideTree& tree, std::span<const BvhTriangle> triangles, std::span<const SampleRay> rays) {
  const TreeSimulation simulation(tree, triangles);
  TraceCounts counts;
  for (const SampleRay& ray : rays) simulation.trace(ray, counts);
  return mean_cost(counts, rays.size());
}

}  // namespace zc
