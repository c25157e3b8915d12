// SPDX-License-Identifier: Apache-2.0
// The truth that engines are held against: closest hits in double precision, and what a float engine may report
// instead.
//
// Borrows the triangles. Threads: const methods from any. Deterministic at any thread count: equal distances go to the
// lowest index.
//
// A report is right when it lies within the float rounding bound of a closest hit. The bound is a length,
//   e = kRoundings * 2^-24 * R,    R = distance of the reported triangle's farthest corner from the ray's origin,
// because a float test subtracts the origin from the corners (one rounding of at most 2^-24 R), shears them (a
// division, a product and a difference: with the 2.5 ulp that Vulkan grants a division, nine more), and compares
// products of them (one more), in each of two directions: the test is the exact test of a triangle moved by less than
// e. So
//   - the reported point o + t d must lie within e of the reported triangle. A shift of e in space moves t by e divided
//     by the cosine of incidence: the test on the point grants just that;
//   - no triangle may be met for certain nearer than the ray comes within 2 e of the reported one. A hit is certain
//   when
//     the ray, and all of a ring of rays around it at distance 2 e, meet something that near: within rounding of a
//     silhouette one of the ring passes the edge by, while along an edge that two triangles share all of them are
//     stopped, so that a leak through a closed surface is a mismatch. Surfaces within 2 e of the ray's origin do not
//     count as certain.
// Source of the error terms: Woop, Benthin & Wald 2013, section 4; Ize 2013, section 2.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <span>
#include <vector>

#include "replay/bench/engines/trace_engine.h"

namespace zc::bench {

inline constexpr double kRoundings = 16;

struct OracleRay {
  glm::dvec3 origin;
  glm::dvec3 direction;
};

struct OracleHit {
  double t = std::numeric_limits<double>::infinity();
  std::uint32_t triangle = kMiss;
};

class Oracle {
 public:
  explicit Oracle(std::span<const BenchTriangle> triangles);

  // Triangles within `clear_m` of the origin are passed through.
  [[nodiscard]] OracleHit trace(const OracleRay& ray, double clear_m = -1) const;
  [[nodiscard]] std::vector<OracleHit> trace(std::span<const BenchRay> rays, unsigned threads) const;
  // No point of a triangle lies farther from `point`.
  [[nodiscard]] double farthest_m(const glm::dvec3& point) const;
  [[nodiscard]] std::array<glm::dvec3, 3> corners(std::uint32_t triangle) const;

 private:
  struct Node {
    glm::dvec3 min, max;
    std::uint32_t first = 0;  // of the leaf's triangles, or of the two children
    std::uint32_t count = 0;  // 0: inner
  };
  void build(std::uint32_t node, std::uint32_t first, std::uint32_t count, std::span<const glm::dvec3> centers);

  std::span<const BenchTriangle> triangles_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

// Distance along the ray at which it hits the triangle, edges included, or infinity. May be negative.
double intersect(const OracleRay& ray, const std::array<glm::dvec3, 3>& corners);
double distance_to_triangle(const glm::dvec3& point, const std::array<glm::dvec3, 3>& corners);

enum class Verdict : std::uint8_t { kSame, kTied, kMissedByBoth, kMismatch };

Verdict judge(const Oracle& oracle, const BenchRay& ray, const OracleHit& expected, const BenchHit& reported,
              std::size_t triangle_count);

// Of an engine that says only whether something is hit. A ray that hits nothing may still be stopped where it passes
// within rounding of a triangle; of which is not known, so that the bound is that of the farthest one.
Verdict judge_any_hit(const Oracle& oracle, const BenchRay& ray, const OracleHit& expected, const BenchHit& reported,
                      std::size_t triangle_count);

struct Comparison {
  std::uint64_t same = 0;
  std::uint64_t tied = 0;
  std::uint64_t missed_by_both = 0;
  std::uint64_t mismatches = 0;
  std::size_t first_mismatch = SIZE_MAX;  // ray
};

Comparison compare(const Oracle& oracle, std::span<const BenchRay> rays, std::span<const OracleHit> expected,
                   std::span<const BenchHit> reported, std::size_t triangle_count, bool any_hit, unsigned threads);

}  // namespace zc::bench
