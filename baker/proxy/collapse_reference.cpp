// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/proxy/collapse_reference.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <iterator>

namespace zc {
namespace {

constexpr double kSamplesPerFace = 4;          // of those in faces and on edges, on average
constexpr double kAppearanceTolerance = 0.25;  // of the tolerance: narrower stripes may take the appearance beside them
constexpr double kWide = 1;                    // tolerances

}  // namespace

CollapseReference::CollapseReference(const LatticeMesh& mesh, std::span<const std::uint16_t> appearances,
                                     double tolerance, Work& work)
    : work_(work),
      mesh_(mesh),
      appearances_(appearances),
      bvh_(mesh, appearances),
      tolerance_(tolerance),
      edges_(face_edges(mesh)) {
  double area = 0;
  for (const LatticeFace& face : mesh.faces) area += face_area(mesh, face);
  LatticeMesh wide;
  wide.vertices = mesh.vertices;
  std::ranges::copy_if(mesh.faces, std::back_inserter(wide.faces),
                       [&](const LatticeFace& face) { return narrowest(corners_of(mesh, face)) > kWide * tolerance; });
  wide_ = DistanceBvh(wide);
  const double spacing =
      std::max(2 * tolerance, std::sqrt(area / (kSamplesPerFace * static_cast<double>(mesh.faces.size()))));
  sample_faces(spacing);
  sample_edges(spacing);
}

void CollapseReference::sample_faces(double spacing) {
  std::vector<bool> seen(mesh_.vertices.size(), false);
  for (std::uint32_t f = 0; f < mesh_.faces.size(); ++f) {
    const Corners c = corners_of(mesh_, mesh_.faces[f]);
    for (std::size_t i = 0; i < 3; ++i) {
      if (!seen[mesh_.faces[f].v[i]]) add_sample(c[i], f);
      seen[mesh_.faces[f].v[i]] = true;
    }
    add_sample((c[0] + c[1] + c[2]) / 3.0, f);
    // The R2 sequence (Roberts 2018) keeps samples apart.
    const double count = face_area(mesh_, mesh_.faces[f]) / (spacing * spacing);
    for (double n = 1; n <= count; ++n) {
      double u = 0.5 + n * 0.7548776662466927;
      double v = 0.5 + n * 0.5698402909980532;
      u -= std::floor(u);
      v -= std::floor(v);
      if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
      }
      add_sample(c[0] + (c[1] - c[0]) * u + (c[2] - c[0]) * v, f);
    }
  }
}

// Fans of long triangles have far more of edges than of area.
void CollapseReference::sample_edges(double spacing) {
  double length = 0;
  for_each_edge(edges_, [&](std::span<const FaceEdge> edge) {
    length += glm::distance(point(edge[0].low), point(edge[0].high));
  });
  const double along = std::max(spacing, length / (kSamplesPerFace * static_cast<double>(mesh_.faces.size())));
  for_each_edge(edges_, [&](std::span<const FaceEdge> edge) {
    const glm::dvec3 a = point(edge[0].low);
    const glm::dvec3 ab = point(edge[0].high) - a;
    const auto n = static_cast<int>(glm::length(ab) / along);
    for (int i = 1; i <= n; ++i) add_sample(a + ab * (double(i) / (n + 1)), edge[0].face);
  });
}

void CollapseReference::add_sample(const glm::dvec3& p, std::uint32_t face) {
  samples_.push_back(
      {p, bvh_.appearances_within(p, kAppearanceTolerance * tolerance_, appearance(face), &work_), face});
}

bool CollapseReference::is_at_wide_faces(const glm::dvec3& p) const {
  return wide_.closest_of_appearance(p, 0, 2 * tolerance_, 0, &work_) <= tolerance_;
}

double narrowest(const Corners& c) {
  const double area = glm::length(glm::cross(c[1] - c[0], c[2] - c[0]));
  const double longest = std::max({glm::distance(c[0], c[1]), glm::distance(c[1], c[2]), glm::distance(c[2], c[0])});
  return longest > 0 ? area / longest : 0;
}

}  // namespace zc
