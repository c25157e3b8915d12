// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/proxy/patches.h"

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <map>

#include "baker/repair/union_find.h"

namespace zc {
namespace {

struct Edge {
  std::uint32_t low, high, face;
};

std::vector<Edge> sorted_edges(const LatticeMesh& mesh) {
  std::vector<Edge> edges;
  edges.reserve(3 * mesh.faces.size());
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
    const auto& v = mesh.faces[f].v;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = v[i];
      const std::uint32_t b = v[(i + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), f});
    }
  }
  std::ranges::sort(edges, [](const Edge& a, const Edge& b) {
    return std::array{a.low, a.high, a.face} < std::array{b.low, b.high, b.face};
  });
  return edges;
}

bool alike(const LatticeFace& a, const LatticeFace& b) { return a.material == b.material && a.ground == b.ground; }

double length(const LatticeMesh& mesh, const Edge& edge) {
  const LatticePoint& a = mesh.vertices[edge.low];
  const LatticePoint& b = mesh.vertices[edge.high];
  return glm::length(glm::dvec3(double(a[0]) - b[0], double(a[1]) - b[1], double(a[2]) - b[2]));
}

}  // namespace

void absorb_small_patches(LatticeMesh& mesh, double size) {
  const std::vector<Edge> edges = sorted_edges(mesh);
  UnionFind patches(mesh.faces.size());
  // Calls `pair` for every two faces at one edge.
  const auto for_neighbours = [&](const auto& pair) {
    for (std::size_t i = 0; i < edges.size(); ++i) {
      for (std::size_t j = i + 1; j < edges.size() && edges[j].low == edges[i].low && edges[j].high == edges[i].high;
           ++j)
        pair(edges[i], edges[j]);
    }
  };
  for_neighbours([&](const Edge& a, const Edge& b) {
    if (alike(mesh.faces[a.face], mesh.faces[b.face])) patches.join(a.face, b.face);
  });
  std::vector<LatticeBox> boxes(mesh.faces.size());
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f)
    for (const std::uint32_t v : mesh.faces[f].v) boxes[patches.find(f)].add(mesh.vertices[v]);

  // Border length of every small patch against the materials of large ones of its kind.
  std::map<std::uint32_t, std::map<std::uint16_t, double>> borders;
  const auto add = [&](const Edge& small, const Edge& large) {
    const std::uint32_t from = patches.find(small.face);
    const std::uint32_t to = patches.find(large.face);
    if (from == to || boxes[from].diagonal() >= size || boxes[to].diagonal() < size) return;
    if (mesh.faces[small.face].ground != mesh.faces[large.face].ground) return;
    borders[from][mesh.faces[large.face].material] += length(mesh, small);
  };
  for_neighbours([&](const Edge& a, const Edge& b) {
    add(a, b);
    add(b, a);
  });
  std::map<std::uint32_t, std::uint16_t> replacement;
  for (const auto& [patch, materials] : borders) {
    const auto longest = std::max_element(materials.begin(), materials.end(),
                                          [](const auto& a, const auto& b) { return a.second < b.second; });
    replacement[patch] = longest->first;
  }
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
    const auto found = replacement.find(patches.find(f));
    if (found != replacement.end()) mesh.faces[f].material = found->second;
  }
}

}  // namespace zc
