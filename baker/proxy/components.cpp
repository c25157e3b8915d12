// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/proxy/components.h"

#include <algorithm>
#include <cmath>
#include <glm/vec3.hpp>
#include <limits>
#include <map>
#include <vector>

#include "baker/distance/distance_bvh.h"
#include "baker/repair/manifold_fans.h"
#include "baker/repair/union_find.h"

namespace zc {
namespace {

constexpr double kSquareDiagonals = 4;

struct Component {
  LatticeBox box;
  double area = 0;
  std::size_t faces = 0;
  std::size_t largest_face = 0;
  double largest_area = 0;
  bool ground = false;
  bool drop = false;
};

struct Components {
  std::vector<Component> list;  // in order of their first face
  std::vector<std::uint32_t> of_face;
};

// Parts hang together by manifold edges: what edge collapse works on. Ground and objects are separate parts.
Components find_components(const LatticeMesh& mesh) {
  const ManifoldFans fans = split_into_fans(mesh);
  const auto half = static_cast<std::uint32_t>(fans.source_vertex.size());
  UnionFind parts(2 * std::size_t{half});
  const auto key = [&](std::size_t face, std::size_t i) {
    return fans.face_fans[face][i] + (mesh.faces[face].ground ? half : 0U);
  };
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    for (std::size_t i = 1; i < 3; ++i) parts.join(key(f, 0), key(f, i));
  Components out;
  std::vector<std::uint32_t> number(2 * std::size_t{half}, UINT32_MAX);
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const LatticeFace& face = mesh.faces[f];
    const std::uint32_t root = parts.find(key(f, 0));
    if (number[root] == UINT32_MAX) {
      number[root] = static_cast<std::uint32_t>(out.list.size());
      out.list.emplace_back();
      out.list.back().ground = face.ground;
    }
    Component& part = out.list[number[root]];
    for (const std::uint32_t v : face.v) part.box.add(mesh.vertices[v]);
    const double area = face_area(mesh, face);
    if (area > part.largest_area) part.largest_face = f;
    part.largest_area = std::max(part.largest_area, area);
    part.area += area;
    ++part.faces;
    out.of_face.push_back(number[root]);
  }
  return out;
}

void remove_marked(LatticeMesh& mesh, const Components& parts) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < mesh.faces.size(); ++i)
    if (!parts.list[parts.of_face[i]].drop) mesh.faces[kept++] = mesh.faces[i];
  mesh.faces.resize(kept);
  weld(mesh);
}

// Candidates from the least, without the last one if nothing else would be left.
template <class Size>
std::vector<std::uint32_t> candidates(const Components& parts, Size size) {
  std::vector<std::uint32_t> order;
  bool any_ground = false;
  for (std::uint32_t i = 0; i < parts.list.size(); ++i) {
    if (parts.list[i].ground) {
      any_ground = true;
    } else {
      order.push_back(i);
    }
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return size(parts.list[a]) < size(parts.list[b]); });
  if (!any_ground && !order.empty()) order.pop_back();
  return order;
}

// Per square of a coarse grid, the largest part whose centre lies in it.
std::vector<bool> find_keepers(const Components& parts, double square) {
  std::map<std::array<std::int64_t, 2>, std::uint32_t> largest;
  for (std::uint32_t i = 0; i < parts.list.size(); ++i) {
    std::array<std::int64_t, 2> key = {};
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const double center = (double(parts.list[i].box.min[axis]) + double(parts.list[i].box.max[axis])) / 2;
      key[axis] = static_cast<std::int64_t>(std::floor(center / square));
    }
    const auto [at, added] = largest.try_emplace(key, i);
    if (!added && parts.list[i].box.diagonal() > parts.list[at->second].box.diagonal()) at->second = i;
  }
  std::vector<bool> keep(parts.list.size(), false);
  for (const auto& [key, i] : largest) keep[i] = true;
  return keep;
}

// For a face this far from all that is left. If all of its part is lost: closed, within the part's box, the tetrahedron
// on every other corner. Ground, what is flat and what is partly there gets the face itself.
LatticeMesh make_stand_in(const LatticeMesh& mesh, std::uint32_t face_index, const Components& parts, double distance) {
  const LatticeFace& face = mesh.faces[face_index];
  const Component& part = parts.list[parts.of_face[face_index]];
  const LatticePoint& a = part.box.min;
  const LatticePoint& b = part.box.max;
  LatticeMesh out;
  if (part.ground || part.box.diagonal() > distance || a[0] == b[0] || a[1] == b[1] || a[2] == b[2]) {
    for (const std::uint32_t v : face.v) out.vertices.push_back(mesh.vertices[v]);
    out.faces = {{{0, 1, 2}, face.material, face.ground}};
    return out;
  }
  out.vertices = {{a[0], a[1], a[2]}, {b[0], b[1], a[2]}, {b[0], a[1], b[2]}, {a[0], b[1], b[2]}};
  for (const auto& v : {std::array<std::uint32_t, 3>{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}})
    out.faces.push_back({v, mesh.faces[part.largest_face].material, false});
  return out;
}

}  // namespace

void add_stand_ins(const LatticeMesh& source, double enough, std::size_t budget, LatticeMesh& mesh) {
  const Components parts = find_components(source);
  struct Lost {
    std::uint32_t face;
    glm::dvec3 center;
    double distance;
  };
  const DistanceBvh left(mesh);
  std::vector<Lost> lost;
  for (std::uint32_t f = 0; f < source.faces.size(); ++f) {
    glm::dvec3 center(0);
    for (const std::uint32_t v : source.faces[f].v)
      for (int axis = 0; axis < 3; ++axis) center[axis] += source.vertices[v][static_cast<std::size_t>(axis)] / 3.0;
    const double distance = left.closest_of_appearance(center, 0, std::numeric_limits<double>::infinity());
    if (distance > enough) lost.push_back({f, center, distance});
  }
  const auto nearer = [](const Lost& a, const Lost& b) { return a.distance < b.distance; };
  while (!lost.empty()) {
    const Lost farthest = *std::max_element(lost.begin(), lost.end(), nearer);  // of equals the first
    const LatticeMesh stand_in = make_stand_in(source, farthest.face, parts, farthest.distance);
    if (stand_in.faces.size() > budget) break;
    budget -= stand_in.faces.size();
    append(mesh, stand_in);
    const DistanceBvh added(stand_in);
    for (Lost& other : lost) other.distance = added.closest_of_appearance(other.center, 0, other.distance);
    // The face itself is stood in for, wherever its centre is.
    std::erase_if(lost, [&](const Lost& l) { return l.face == farthest.face || l.distance <= enough; });
  }
  weld(mesh);
}

void drop_small_components(LatticeMesh& mesh, double diagonal, std::size_t target_faces) {
  Components parts = find_components(mesh);
  // A part far from all others stays: what is dropped must lie near something that is left.
  const std::vector<bool> keep = find_keepers(parts, kSquareDiagonals * diagonal);
  std::size_t left = mesh.faces.size();
  for (const std::uint32_t i : candidates(parts, [](const Component& c) { return c.box.diagonal(); })) {
    if (left <= target_faces || parts.list[i].box.diagonal() >= diagonal) break;
    // What contains most of the triangles is for the decimation: dropping it would fall far below the target.
    if (keep[i] || left - parts.list[i].faces < target_faces / 2) continue;
    parts.list[i].drop = true;
    left -= parts.list[i].faces;
  }
  remove_marked(mesh, parts);
}

void drop_components_to(LatticeMesh& mesh, std::size_t target_faces) {
  Components parts = find_components(mesh);
  std::size_t left = mesh.faces.size();
  for (const std::uint32_t i : candidates(parts, [](const Component& c) { return c.area; })) {
    if (left <= target_faces) break;
    parts.list[i].drop = true;
    left -= parts.list[i].faces;
  }
  remove_marked(mesh, parts);
}

}  // namespace zc
