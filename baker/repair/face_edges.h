// SPDX-License-Identifier: GPL-3.0-or-later
// The edges of a triangle soup, each with the faces that share it. Thread-safe: no state. Deterministic.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "baker/scene/lattice_mesh.h"

namespace zc {

struct FaceEdge {
  std::uint32_t low = 0;  // vertices; low < high
  std::uint32_t high = 0;
  std::uint32_t face = 0;
  std::uint8_t side = 0;  // from the face's corner `side` to the next
  bool forward = false;   // from `low` to `high`

  [[nodiscard]] bool same_place(const FaceEdge& other) const { return low == other.low && high == other.high; }
};

// Sorted by vertices, then by face; faces must not be flat.
std::vector<FaceEdge> face_edges(const LatticeMesh& mesh);

// Calls visit(span) for the faces of every edge, in order.
template <class Visit>
void for_each_edge(const std::vector<FaceEdge>& edges, const Visit& visit) {
  for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
    while (end < edges.size() && edges[end].same_place(edges[begin])) ++end;
    visit(std::span(edges).subspan(begin, end - begin));
  }
}

// Edges of one face alone.
std::vector<FaceEdge> open_edges(const LatticeMesh& mesh);

// The open edges at each vertex.
class EdgesAtVertex {
 public:
  EdgesAtVertex(const std::vector<FaceEdge>& edges, std::size_t vertex_count);
  // Indices of `edges`, ascending.
  [[nodiscard]] std::span<const std::uint32_t> at(std::uint32_t vertex) const {
    return std::span(edges_).subspan(first_[vertex], first_[vertex + 1] - first_[vertex]);
  }

 private:
  std::vector<std::uint32_t> first_;
  std::vector<std::uint32_t> edges_;
};

}  // namespace zc
