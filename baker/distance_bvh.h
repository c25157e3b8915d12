// SPDX-License-Identifier: GPL-3.0-or-later
// Closest point on a triangle mesh, exact up to rounding. Source: Ericson, Real-Time Collision Detection (2005), 5.1.5.
// Borrows nothing: copies what it needs. Units: steps. Thread-safe once built.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "baker/lattice_mesh.h"

namespace zc {

struct ClosestHit {
  double distance = 0;
  double alignment = 0;  // |cosine| of the reference normal and the hit's
  std::uint16_t material = 0;
};

class DistanceBvh {
 public:
  DistanceBvh() = default;
  explicit DistanceBvh(const LatticeMesh& mesh);

  [[nodiscard]] bool empty() const { return triangles_.empty(); }
  [[nodiscard]] const LatticeBox& bounds() const { return bounds_; }
  [[nodiscard]] double distance_to_bounds(const glm::dvec3& p) const;

  // Improves `best` (start with an infinite distance). Of triangles within `tie` steps of the closest, the one best
  // aligned with `normal` wins: at an edge the closest point belongs to several.
  void closest(const glm::dvec3& p, const glm::dvec3& normal, double tie, ClosestHit& best) const;

  // Distance to the closest triangle whose material is of `look`, or `limit` when none is nearer than that.
  [[nodiscard]] double closest_of_look(const glm::dvec3& p, std::span<const std::uint16_t> looks, std::uint16_t look,
                                       double limit) const;

 private:
  struct Node {
    glm::vec3 min;
    glm::vec3 max;
    std::uint32_t first = 0;  // left child (right follows) or first triangle
    std::uint32_t count = 0;  // 0: inner
  };
  struct Triangle {
    glm::dvec3 a, ab, ac, normal;
    std::uint16_t material;
  };

  // Calls visit(triangle) for the triangles of every leaf whose box is within reach() of p, nearest boxes first.
  template <class Reach, class Visit>
  void visit_near(const glm::dvec3& p, const Reach& reach, const Visit& visit) const;

  std::vector<Node> nodes_;
  std::vector<Triangle> triangles_;
  LatticeBox bounds_;
};

}  // namespace zc
