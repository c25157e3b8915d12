// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/repair/face_edges.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <tuple>

namespace zc {

std::vector<FaceEdge> face_edges(const LatticeMesh& mesh) {
  std::vector<FaceEdge> edges;
  edges.reserve(3 * mesh.faces.size());
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
    const auto& v = mesh.faces[f].v;
    for (std::uint8_t side = 0; side < 3; ++side) {
      const std::uint32_t a = v[side];
      const std::uint32_t b = v[(side + 1U) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), f, side, a < b});
    }
  }
  // A total order: the same at any thread count.
  tbb::parallel_sort(edges.begin(), edges.end(), [](const FaceEdge& l, const FaceEdge& r) {
    return std::tie(l.low, l.high, l.face, l.side) < std::tie(r.low, r.high, r.face, r.side);
  });
  return edges;
}

std::vector<FaceEdge> open_edges(const LatticeMesh& mesh) {
  std::vector<FaceEdge> open;
  for_each_edge(face_edges(mesh), [&](std::span<const FaceEdge> edge) {
    if (edge.size() == 1) open.push_back(edge[0]);
  });
  return open;
}

EdgesAtVertex::EdgesAtVertex(const std::vector<FaceEdge>& edges, std::size_t vertex_count) : first_(vertex_count + 1) {
  for (const FaceEdge& edge : edges) {
    ++first_[edge.low + 1];
    ++first_[edge.high + 1];
  }
  for (std::size_t v = 0; v < vertex_count; ++v) first_[v + 1] += first_[v];
  edges_.resize(2 * edges.size());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::uint32_t e = 0; e < edges.size(); ++e) {
    edges_[next[edges[e].low]++] = e;
    edges_[next[edges[e].high]++] = e;
  }
}

}  // namespace zc
