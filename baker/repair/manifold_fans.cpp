// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/repair/manifold_fans.h"

#include <algorithm>
#include <map>
#include <set>

#include "baker/repair/union_find.h"

namespace zc {
namespace {

struct HalfEdge {
  std::uint64_t edge;    // smaller vertex << 32 | larger
  std::uint32_t corner;  // where it starts: 3 * face + i
  bool forward;          // from the smaller vertex
};

std::uint32_t next_corner(std::uint32_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }

}  // namespace

ManifoldFans split_into_fans(const LatticeMesh& mesh) {
  const auto corner_count = static_cast<std::uint32_t>(3 * mesh.faces.size());
  std::vector<HalfEdge> edges;
  edges.reserve(corner_count);
  for (std::uint32_t c = 0; c < corner_count; ++c) {
    const std::uint32_t a = mesh.faces[c / 3].v[c % 3];
    const std::uint32_t b = mesh.faces[c / 3].v[(c + 1) % 3];
    edges.push_back({std::uint64_t{std::min(a, b)} << 32U | std::max(a, b), c, a < b});
  }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& l, const HalfEdge& r) {
    return l.edge != r.edge ? l.edge < r.edge : l.corner < r.corner;
  });
  UnionFind fans(corner_count);
  for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
    while (end < edges.size() && edges[end].edge == edges[begin].edge) ++end;
    if (end - begin != 2 || edges[begin].forward == edges[begin + 1].forward) continue;
    const std::uint32_t c = edges[begin].corner;
    const std::uint32_t d = edges[begin + 1].corner;
    fans.join(c, next_corner(d));
    fans.join(next_corner(c), d);
  }
  ManifoldFans out;
  std::vector<std::uint32_t> fan_of(corner_count);
  out.face_fans.resize(mesh.faces.size());
  for (std::uint32_t c = 0; c < corner_count; ++c) {
    const std::uint32_t root = fans.find(c);
    if (root == c) {
      fan_of[c] = static_cast<std::uint32_t>(out.source_vertex.size());
      out.source_vertex.push_back(mesh.faces[c / 3].v[c % 3]);
    }
    out.face_fans[c / 3][c % 3] = fan_of[root];
  }
  return out;
}

void cut_wide_fans(LatticeMesh& mesh, std::size_t limit, std::vector<bool>& locked) {
  std::vector<std::size_t> count(mesh.vertices.size());
  for (const LatticeFace& face : mesh.faces)
    for (const std::uint32_t v : face.v) ++count[v];
  std::map<std::uint32_t, std::vector<std::uint32_t>> wide;  // faces by vertex
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f)
    for (const std::uint32_t v : mesh.faces[f].v)
      if (count[v] > limit) wide[v].push_back(f);

  for (const auto& [hub, faces] : wide) {
    std::map<std::uint32_t, std::vector<std::uint32_t>> spokes;  // faces by the edge's other vertex
    for (const std::uint32_t f : faces)
      for (const std::uint32_t v : mesh.faces[f].v)
        if (v != hub) spokes[v].push_back(f);
    std::map<std::uint32_t, std::size_t> sector;  // by face
    std::set<std::uint32_t> passed;               // spokes
    for (const std::uint32_t first : faces) {     // neighbours after one another
      std::vector<std::uint32_t> next = {first};
      while (!next.empty()) {
        const std::uint32_t f = next.back();
        next.pop_back();
        if (!sector.emplace(f, sector.size() / limit).second) continue;
        for (const std::uint32_t v : mesh.faces[f].v)
          if (v != hub && passed.insert(v).second) next.insert(next.end(), spokes[v].begin(), spokes[v].end());
      }
    }
    for (const auto& [v, around] : spokes)
      for (const std::uint32_t f : around)
        if (sector[f] != sector[around.front()]) locked[v] = true;
    locked[hub] = true;
    const auto copies = static_cast<std::uint32_t>(mesh.vertices.size());
    const std::size_t sectors = (faces.size() + limit - 1) / limit;
    mesh.vertices.insert(mesh.vertices.end(), sectors - 1, LatticePoint(mesh.vertices[hub]));
    locked.resize(mesh.vertices.size(), true);
    for (const auto& [f, s] : sector)
      if (s > 0) *std::ranges::find(mesh.faces[f].v, hub) = copies + static_cast<std::uint32_t>(s) - 1;
  }
}

}  // namespace zc
