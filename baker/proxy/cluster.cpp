// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/proxy/cluster.h"

#include <algorithm>

#include "base/check.h"

namespace zc {

LatticeMesh cluster_vertices(const LatticeMesh& mesh, const std::vector<bool>& locked, std::uint32_t cell_log2) {
  ZC_CHECK(locked.size() == mesh.vertices.size());
  struct Member {
    LatticePoint cell;
    std::uint32_t vertex;
    bool operator<(const Member& o) const { return cell != o.cell ? cell < o.cell : vertex < o.vertex; }
  };
  std::vector<Member> members;
  for (std::uint32_t i = 0; i < mesh.vertices.size(); ++i) {
    if (locked[i]) continue;
    LatticePoint cell = mesh.vertices[i];
    for (std::int32_t& c : cell) c >>= static_cast<int>(cell_log2);
    members.push_back({cell, i});
  }
  std::sort(members.begin(), members.end());
  LatticeMesh out = mesh;
  for (std::size_t begin = 0, end = 0; begin < members.size(); begin = end) {
    std::array<std::int64_t, 3> sum = {};
    for (; end < members.size() && members[end].cell == members[begin].cell; ++end)
      for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += mesh.vertices[members[end].vertex][axis];
    const auto count = static_cast<std::int64_t>(end - begin);
    std::uint32_t nearest = members[begin].vertex;
    std::int64_t nearest_distance = INT64_MAX;
    for (std::size_t i = begin; i < end; ++i) {
      std::int64_t distance = 0;  // along the axes: only the order matters
      for (std::size_t axis = 0; axis < 3; ++axis)
        distance += std::abs(mesh.vertices[members[i].vertex][axis] - sum[axis] / count);
      if (distance < nearest_distance) {
        nearest = members[i].vertex;
        nearest_distance = distance;
      }
    }
    for (std::size_t i = begin; i < end; ++i) out.vertices[members[i].vertex] = mesh.vertices[nearest];
  }
  clean(out);
  return out;
}

}  // namespace zc
