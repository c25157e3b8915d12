// SPDX-License-Identifier: GPL-3.0-or-later
// What vertices collapse against: the mesh as it was, a tree over it, and samples that must stay covered.
// Borrows the mesh, the appearances and the work. Units: steps. Not thread-safe: queries count work.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "baker/distance/distance_bvh.h"
#include "baker/distance/hausdorff_bound.h"
#include "baker/repair/face_edges.h"

namespace zc {

class CollapseReference {
 public:
  struct Sample {
    glm::dvec3 point;
    AppearanceSet appearances;  // that it may be given: those of the mesh nearby
    std::uint32_t face = 0;     // of the mesh
  };

  // appearances: per material.
  CollapseReference(const LatticeMesh& mesh, std::span<const std::uint16_t> appearances, double tolerance, Work& work);

  void add_sample(const glm::dvec3& p, std::uint32_t face);

  [[nodiscard]] const LatticeMesh& mesh() const { return mesh_; }
  [[nodiscard]] const DistanceBvh& bvh() const { return bvh_; }
  [[nodiscard]] const std::vector<FaceEdge>& edges() const { return edges_; }
  [[nodiscard]] const std::vector<Sample>& samples() const { return samples_; }
  [[nodiscard]] double tolerance() const { return tolerance_; }
  // Near faces that are no part of a bar.
  [[nodiscard]] bool is_at_wide_faces(const glm::dvec3& p) const;
  [[nodiscard]] std::uint16_t appearance(std::uint32_t face) const { return appearances_[mesh_.faces[face].material]; }
  [[nodiscard]] glm::dvec3 point(std::uint32_t vertex) const { return to_dvec(mesh_.vertices[vertex]); }

 private:
  void sample_faces(double spacing);
  void sample_edges(double spacing);

  Work& work_;
  const LatticeMesh& mesh_;
  std::span<const std::uint16_t> appearances_;
  DistanceBvh bvh_;
  DistanceBvh wide_;  // of faces that are no part of a bar
  double tolerance_;
  std::vector<FaceEdge> edges_;
  std::vector<Sample> samples_;
};

// The height of a triangle over its longest side.
double narrowest(const Corners& corners);

}  // namespace zc
