// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/repair/orient.h"

#include <vector>

#include "baker/distance/lattice_distance.h"
#include "baker/repair/face_edges.h"

namespace zc {
namespace {

// GCC's 128-bit integers are an extension; six times the volume below 2^32 faces needs 126 bits.
__extension__ typedef __int128 Wide;

constexpr std::uint32_t kNone = UINT32_MAX;

struct Link {
  std::uint32_t face = kNone;  // across the side
  bool agrees = true;          // both face the same side
};

struct Component {
  std::vector<std::uint32_t> faces;
  bool closed = true;
  bool ground = true;
  bool one_sided = false;
};

class Orienter {
 public:
  explicit Orienter(LatticeMesh& mesh) : mesh_(mesh), links_(3 * mesh.faces.size()), turn_(mesh.faces.size(), false) {
    for_each_edge(face_edges(mesh), [&](std::span<const FaceEdge> edge) {
      if (edge.size() != 2) return;
      const bool agrees = edge[0].forward != edge[1].forward;
      links_[3 * std::size_t{edge[0].face} + edge[0].side] = {edge[1].face, agrees};
      links_[3 * std::size_t{edge[1].face} + edge[1].side] = {edge[0].face, agrees};
    });
  }

  OrientCounts run() {
    OrientCounts counts;
    std::vector<bool> seen(mesh_.faces.size(), false);
    for (std::uint32_t first = 0; first < mesh_.faces.size(); ++first) {
      if (seen[first]) continue;
      const Component component = collect(first, seen);
      counts.one_sided_parts += component.one_sided ? 1 : 0;
      const bool turn_all = faces_wrong_side(component);
      for (const std::uint32_t f : component.faces) {
        if (turn_[f] == turn_all) continue;
        std::swap(mesh_.faces[f].v[1], mesh_.faces[f].v[2]);
        ++counts.turned;
      }
    }
    return counts;
  }

 private:
  Component collect(std::uint32_t first, std::vector<bool>& seen) {
    Component out;
    out.faces.push_back(first);
    seen[first] = true;
    for (std::size_t i = 0; i < out.faces.size(); ++i) {
      const std::uint32_t f = out.faces[i];
      out.ground = out.ground && mesh_.faces[f].ground;
      for (std::size_t side = 0; side < 3; ++side) {
        const Link& link = links_[3 * std::size_t{f} + side];
        if (link.face == kNone) {
          out.closed = false;
          continue;
        }
        const bool turned = turn_[f] == link.agrees;
        if (!seen[link.face]) {
          seen[link.face] = true;
          turn_[link.face] = turned;
          out.faces.push_back(link.face);
        } else if (turn_[link.face] != turned) {
          out.one_sided = true;
        }
      }
    }
    return out;
  }

  // Of the component as its first face has it.
  [[nodiscard]] bool faces_wrong_side(const Component& component) const {
    const LatticePoint origin = mesh_.vertices[mesh_.faces[component.faces[0]].v[0]];
    Wide volume = 0;
    Wide upwards = 0;
    Wide kept = 0;  // area that keeps its side less that which turns, as the sum of its shadows along the axes
    for (const std::uint32_t f : component.faces) {
      const auto& v = mesh_.faces[f].v;
      const LatticePoint& a = mesh_.vertices[v[0]];
      const LatticeVector normal = cross(difference(mesh_.vertices[v[1]], a), difference(mesh_.vertices[v[2]], a));
      const LatticeVector from_origin = difference(a, origin);
      const int sign = turn_[f] ? -1 : 1;
      for (std::size_t i = 0; i < 3; ++i) {
        volume += sign * Wide{normal[i]} * from_origin[i];
        kept += sign * (normal[i] < 0 ? -Wide{normal[i]} : Wide{normal[i]});
      }
      upwards += sign * Wide{normal[2]};
    }
    if (component.closed && !component.one_sided && volume != 0) return volume < 0;
    if (component.ground && upwards != 0) return upwards < 0;
    return kept < 0;
  }

  LatticeMesh& mesh_;
  std::vector<Link> links_;  // three a face
  std::vector<bool> turn_;   // against the first face of the component
};

}  // namespace

OrientCounts orient_faces(MeshPart& part) { return Orienter(part.mesh).run(); }

}  // namespace zc
