// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/repair/slivers.h"

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "baker/distance/lattice_distance.h"
#include "baker/repair/face_edges.h"

namespace zc {
namespace {

// The side that the corner opposite to it lies on.
std::optional<std::size_t> long_side(const LatticeMesh& mesh, const LatticeFace& face) {
  for (std::size_t i = 0; i < 3; ++i) {
    const auto corner = [&](std::size_t k) { return mesh.vertices[face.v[(i + k) % 3]]; };
    if (near_inside(corner(2), corner(0), corner(1))) return i;
  }
  return std::nullopt;
}

}  // namespace

SliverCounts drop_slivers(MeshPart& part) {
  const LatticeMesh& mesh = part.mesh;
  SliverCounts counts;
  std::vector<std::uint32_t> slivers;
  std::vector<std::size_t> sides;
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
    if (const auto side = long_side(mesh, mesh.faces[f])) {
      slivers.push_back(f);
      sides.push_back(*side);
    }
  }
  if (slivers.empty()) return counts;

  const std::vector<FaceEdge> edges = face_edges(mesh);
  std::vector<bool> drop(mesh.faces.size(), false);
  std::vector<bool> held(mesh.faces.size(), false);  // stays: another one went for it
  // A face besides f that stays at the edge; one that is no sliver first.
  const auto neighbour = [&](std::uint32_t f, std::uint32_t a, std::uint32_t b) -> std::optional<std::uint32_t> {
    FaceEdge key;
    key.low = std::min(a, b);
    key.high = std::max(a, b);
    const auto before = [](const FaceEdge& l, const FaceEdge& r) {
      return l.low != r.low ? l.low < r.low : l.high < r.high;
    };
    const auto [begin, end] = std::equal_range(edges.begin(), edges.end(), key, before);
    std::optional<std::uint32_t> found;
    for (auto it = begin; it != end; ++it) {
      if (it->face == f || drop[it->face]) continue;
      const bool solid = !std::binary_search(slivers.begin(), slivers.end(), it->face);
      if (solid) return it->face;
      if (!found) found = it->face;
    }
    return found;
  };
  for (std::size_t i = 0; i < slivers.size(); ++i) {
    const std::uint32_t f = slivers[i];
    if (held[f]) continue;
    const auto& v = mesh.faces[f].v;
    const std::size_t side = sides[i];
    const std::uint32_t a = v[side];
    const std::uint32_t b = v[(side + 1) % 3];
    const std::uint32_t apex = v[(side + 2) % 3];
    if (const auto along = neighbour(f, a, b)) {
      held[*along] = true;
    } else {
      const auto left = neighbour(f, a, apex);
      const auto right = neighbour(f, apex, b);
      if (!left || !right) continue;
      held[*left] = true;
      held[*right] = true;
    }
    drop[f] = true;
    ++counts.dropped;
    counts.moved = std::max(counts.moved, distance_to_line(mesh.vertices[apex], mesh.vertices[a], mesh.vertices[b]));
  }
  part.erase_faces(drop);
  return counts;
}

}  // namespace zc
