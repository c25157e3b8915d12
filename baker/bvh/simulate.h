// SPDX-License-Identifier: GPL-3.0-or-later
// What a wide tree costs to trace, by tracing it: representative reflection rays are taken through the tree as
// shaders/traverse.glsl takes them (children in the order of `slot ^ octant`, all triangles of the leaves that a node's
// slots were hit in before any child node, t_max shrinking with every hit, no second test of a child that waits on the
// stack), and the nodes visited and triangles tested are counted. The surface area heuristic assumes rays that are
// spread evenly and never stop; reflections are neither. The rays, in equal parts, low-discrepancy (Roberts 2018, the R
// sequences) and the same for the same triangles:
//   - mirror rays of street-level views: from points on the zone's triangles, picked by area, the mirrored direction of
//   a
//     view that runs within 20 degrees of level;
//   - rays that come from other zones: through points of the zone's box, entering from outside, in directions of mirror
//     rays of its surfaces.
// z is up. Units: the zone's lattice. Deterministic. Thread-safe: no state.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "baker/bvh/collapse.h"

namespace zc {

// Cost of what a ray does, after what it fetches: a node's 20 words against about 8 words a triangle.
inline constexpr double kNodeVisitCost = 1.0;
inline constexpr double kTriangleTestCost = 0.4;

struct SampleRay {
  std::array<float, 3> origin;
  std::array<float, 3> direction;  // not zero
};

inline constexpr std::uint32_t kSampleRays = 512;

std::vector<SampleRay> make_sample_rays(std::span<const BvhTriangle> triangles, std::uint32_t count = kSampleRays);

struct SampleHit {
  float t = std::numeric_limits<float>::infinity();
  std::uint32_t triangle = 0xFFFFFFFF;  // none
};

struct TraceCounts {
  std::uint64_t nodes = 0;
  std::uint64_t triangles = 0;
};

// Closest hit, both sides of a triangle; of equal distances the lowest triangle's.
void test_triangle(const BvhTriangle& triangle, std::uint32_t index, const SampleRay& ray, SampleHit& hit);

// Traces through one tree.
class TreeSimulation {
 public:
  TreeSimulation(const WideTree& tree, std::span<const BvhTriangle> triangles);
  SampleHit trace(const SampleRay& ray, TraceCounts& counts) const;

 private:
  using Planes = std::array<float, gpu::kNodeWidth>;
  struct Node {
    std::array<Planes, 6> planes;  // lower x, y, z, upper x, y, z
    std::uint32_t inner = 0;       // slots, bits
    std::uint32_t leaves = 0;
    std::uint32_t first_child = 0;
    std::array<std::uint32_t, gpu::kNodeWidth> first_reference{};
    std::array<std::uint8_t, gpu::kNodeWidth> count{};
  };
  std::vector<Node> nodes_;
  const WideTree* tree_;
  std::span<const BvhTriangle> triangles_;
};

// Cost of one ray, on average.
double mean_cost(const TraceCounts& counts, std::size_t rays);
double simulated_cost(const WideTree& tree, std::span<const BvhTriangle> triangles, std::span<const SampleRay> rays);

}  // namespace zc
