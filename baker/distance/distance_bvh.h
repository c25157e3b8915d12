// SPDX-License-Identifier: GPL-3.0-or-later
// Closest point on a triangle mesh, exact up to rounding. Source: Ericson, Real-Time Collision Detection (2005), 5.1.5.
// Closest triangles of one appearance are found as fast where the appearances are given at construction.
// Borrows nothing: copies what it needs. Units: steps. Thread-safe once built.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "baker/distance/appearance_set.h"
#include "baker/distance/work_budget.h"
#include "baker/scene/lattice_mesh.h"

namespace zc {

struct ClosestHit {
  double distance = 0;
  double alignment = 0;  // |cosine| of the reference normal and the hit's
  std::uint16_t material = 0;
};

struct DistanceTriangle {
  glm::dvec3 a, ab, ac, normal;
  std::uint16_t material = 0;
  std::uint16_t appearance = 0;

  [[nodiscard]] double distance(const glm::dvec3& p) const;
};

// Queries end when `work` is spent, with the best that they found until then, at least of one leaf near by: distances
// are then bounds from above, and appearances may be missing.
class DistanceBvh {
 public:
  DistanceBvh() = default;
  // appearances: per material; none: all are of appearance 0.
  explicit DistanceBvh(const LatticeMesh& mesh, std::span<const std::uint16_t> appearances = {});

  [[nodiscard]] bool empty() const { return triangles_.empty(); }
  [[nodiscard]] const LatticeBox& bounds() const { return bounds_; }
  [[nodiscard]] bool may_have(std::uint16_t appearance) const {
    return !empty() && (nodes_[0].appearances & filter_bit(appearance)) != 0;
  }
  [[nodiscard]] double distance_to_bounds(const glm::dvec3& p) const;

  // Improves `best` (start with an infinite distance); what is within `tie` / 2 steps is close enough. Of triangles
  // within `tie` steps of the closest, the one best aligned with `normal` wins: at an edge the closest point belongs to
  // several. Of very many, some are tried.
  void closest(const glm::dvec3& p, const glm::dvec3& normal, double tie, ClosestHit& best, Work* work = nullptr) const;

  // The closest triangle of `appearance` (none: of any), or one of them within `enough`; sets `distance`, or leaves
  // both when none is nearer.
  void nearest(const glm::dvec3& p, std::optional<std::uint16_t> appearance, double enough,
               const DistanceTriangle*& triangle, double& distance, Work* work = nullptr) const;

  // Distance to the closest triangle of `appearance`, or to any within `enough`, or `limit` when none is nearer than
  // that.
  [[nodiscard]] double closest_of_appearance(const glm::dvec3& p, std::uint16_t appearance, double limit,
                                             double enough = 0, Work* work = nullptr) const;

  // All appearances within `radius`, and the one that is known to be.
  [[nodiscard]] AppearanceSet appearances_within(const glm::dvec3& p, double radius, std::uint16_t known,
                                                 Work* work = nullptr) const;

 private:
  struct Node {
    glm::vec3 min;
    glm::vec3 max;
    std::uint32_t first = 0;        // left child (right follows) or first triangle
    std::uint32_t count = 0;        // 0: inner
    std::uint64_t appearances = 0;  // filter bits of all in it
  };

  // Appearances 64 apart share a bit: it shows where one may be, and a triangle's own appearance decides.
  static std::uint64_t filter_bit(std::uint16_t appearance) { return std::uint64_t{1} << (appearance % 64U); }

  // Calls visit(triangle) for the triangles of every leaf whose box is within reach() of p and that passes
  // enter(filter bits), nearest boxes first.
  template <class Reach, class Enter, class Visit>
  void visit_near(const glm::dvec3& p, const Reach& reach, const Enter& enter, const Visit& visit, Work* work) const;

  std::vector<Node> nodes_;
  std::vector<DistanceTriangle> triangles_;
  LatticeBox bounds_;
  std::uint64_t shared_bits_ = 0;  // filter bits of appearances that a word has no bit of its own for
};

}  // namespace zc
