// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/repair/t_junctions.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <vector>

#include "baker/distance/lattice_distance.h"
#include "baker/repair/face_edges.h"
#include "baker/repair/point_tree.h"

namespace zc {
namespace {

constexpr std::uint32_t kNone = UINT32_MAX;

class Finder {
 public:
  Finder(const LatticeMesh& mesh, const std::vector<FaceEdge>& open)
      : mesh_(mesh), open_(open), at_vertex_(open, mesh.vertices.size()), tree_(mesh.vertices, vertices_of(open)) {}

  // The vertex nearest to the middle of the edge that may be inserted there.
  [[nodiscard]] std::uint32_t find(const FaceEdge& edge) const {
    const LatticePoint& a = mesh_.vertices[edge.low];
    const LatticePoint& b = mesh_.vertices[edge.high];
    const LatticeVector ab = difference(b, a);
    const std::int64_t length2 = dot(ab, ab);
    std::uint32_t best = kNone;
    std::int64_t best_off = 0;
    tree_.visit_near(a, b, [&](std::uint32_t v) {
      const LatticePoint& p = mesh_.vertices[v];
      if (v == edge.low || v == edge.high || !near_inside(p, a, b)) return;
      const std::int64_t off = std::abs(2 * dot(ab, difference(p, a)) - length2);
      if (best != kNone && (off > best_off || (off == best_off && v > best))) return;
      if (!runs_along(v, edge) || !may_split(edge, v)) return;
      best = v;
      best_off = off;
    });
    return best;
  }

 private:
  static std::vector<std::uint32_t> vertices_of(const std::vector<FaceEdge>& open) {
    std::vector<std::uint32_t> vertices;
    for (const FaceEdge& edge : open) vertices.insert(vertices.end(), {edge.low, edge.high});
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    return vertices;
  }

  // Whether an open edge at v covers a part of `edge`.
  [[nodiscard]] bool runs_along(std::uint32_t v, const FaceEdge& edge) const {
    const LatticePoint& p = mesh_.vertices[v];
    const LatticePoint& a = mesh_.vertices[edge.low];
    const LatticePoint& b = mesh_.vertices[edge.high];
    return std::ranges::any_of(at_vertex_.at(v), [&](std::uint32_t e) {
      const FaceEdge& other = open_[e];
      if (other.face == edge.face) return false;
      const std::uint32_t end = other.low == v ? other.high : other.low;
      if (end == edge.low || end == edge.high) return true;
      const LatticePoint& q = mesh_.vertices[end];
      return near_inside(q, a, b) || near_inside(a, p, q) || near_inside(b, p, q);
    });
  }

  // Both halves keep an area and the side they face.
  [[nodiscard]] bool may_split(const FaceEdge& edge, std::uint32_t v) const {
    const LatticeFace& face = mesh_.faces[edge.face];
    const auto corner = [&](std::size_t k) { return mesh_.vertices[face.v[(edge.side + k) % 3]]; };
    const auto normal = [](const LatticePoint& a, const LatticePoint& b, const LatticePoint& c) {
      return cross(difference(b, a), difference(c, a));
    };
    const auto agree = [](const LatticeVector& l, const LatticeVector& r) {
      double sum = 0;  // never near zero unless it is a sliver, which is left alone
      for (std::size_t i = 0; i < 3; ++i) sum += static_cast<double>(l[i]) * static_cast<double>(r[i]);
      return sum > 0;
    };
    const LatticePoint& p = mesh_.vertices[v];
    const LatticeVector whole = normal(corner(0), corner(1), corner(2));
    return agree(whole, normal(corner(0), p, corner(2))) && agree(whole, normal(p, corner(1), corner(2)));
  }

  const LatticeMesh& mesh_;
  const std::vector<FaceEdge>& open_;
  EdgesAtVertex at_vertex_;
  PointTree tree_;
};

}  // namespace

TJunctionCounts repair_t_junctions(MeshPart& part) {
  LatticeMesh& mesh = part.mesh;
  TJunctionCounts counts;
  const std::size_t faces_max = 2 * mesh.faces.size() + 64;
  // A pass halves the chain of vertices along an edge, and splits one side of each face.
  for (bool found = true; found;) {
    found = false;
    const std::vector<FaceEdge> open = open_edges(mesh);
    if (open.empty()) break;
    std::vector<std::uint32_t> insert(open.size());
    const Finder finder(mesh, open);
    tbb::parallel_for(std::size_t{0}, open.size(), [&](std::size_t i) { insert[i] = finder.find(open[i]); });
    std::vector<bool> split(mesh.faces.size(), false);
    for (std::size_t i = 0; i < open.size(); ++i) {
      const std::uint32_t v = insert[i];
      if (v == kNone) continue;
      if (mesh.faces.size() >= faces_max) {
        ++counts.left;
        continue;
      }
      found = true;
      if (split[open[i].face]) continue;
      split[open[i].face] = true;
      ++counts.repaired;
      const auto& p = mesh.vertices;
      counts.moved = std::max(counts.moved, distance_to_line(p[v], p[open[i].low], p[open[i].high]));
      LatticeFace& face = mesh.faces[open[i].face];
      LatticeFace half = face;
      half.v[open[i].side] = v;
      face.v[(open[i].side + 1U) % 3] = v;
      part.object.push_back(part.object[open[i].face]);
      mesh.faces.push_back(half);
    }
    if (counts.left > 0) break;
  }
  return counts;
}

}  // namespace zc
