// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/repair/degenerate_faces.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <tuple>
#include <vector>

namespace zc {
namespace {

// The same three vertices, whatever the orientation.
struct FaceKey {
  std::array<std::uint32_t, 3> sorted;
  std::uint32_t face;
};

}  // namespace

DegenerateFaceCounts drop_degenerate_faces(MeshPart& part) {
  const LatticeMesh& mesh = part.mesh;
  DegenerateFaceCounts counts;
  std::vector<bool> drop(mesh.faces.size(), false);
  std::vector<FaceKey> keys;
  keys.reserve(mesh.faces.size());
  for (std::uint32_t i = 0; i < mesh.faces.size(); ++i) {
    const auto& v = mesh.faces[i].v;
    if (is_degenerate(mesh.vertices[v[0]], mesh.vertices[v[1]], mesh.vertices[v[2]])) {
      drop[i] = true;
      ++counts.flat;
      continue;
    }
    auto sorted = v;
    std::sort(sorted.begin(), sorted.end());
    keys.push_back({sorted, i});
  }
  tbb::parallel_sort(keys.begin(), keys.end(), [](const FaceKey& l, const FaceKey& r) {
    return std::tie(l.sorted, l.face) < std::tie(r.sorted, r.face);
  });
  for (std::size_t begin = 0, end = 0; begin < keys.size(); begin = end) {
    while (end < keys.size() && keys[end].sorted == keys[begin].sorted) ++end;
    std::size_t kept = begin;  // keys[begin, kept) stay
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t face = keys[i].face;
      bool same_side = false;
      bool same_object = false;
      // Few stay: at most one a side, and both sides only of two objects.
      for (std::size_t j = begin; j < kept; ++j) {
        same_side = same_side || rotated(mesh.faces[face].v) == rotated(mesh.faces[keys[j].face].v);
        same_object = same_object || part.object[face] == part.object[keys[j].face];
      }
      if (!same_side && !same_object) {
        std::swap(keys[kept++], keys[i]);
        continue;
      }
      drop[face] = true;
      ++(same_side ? counts.repeated : counts.back_to_back);
    }
  }
  part.erase_faces(drop);
  return counts;
}

}  // namespace zc
