// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/write/left_out.h"

#include <algorithm>

#include "baker/appearance/atlas.h"
#include "shaders/shared/page.h"

namespace zc {
namespace {

// Two coordinates of 16 bits at each corner.
constexpr std::uint64_t kTexcoordBytes = 3 * 2 * sizeof(std::uint16_t);

struct Sum {
  std::uint64_t triangles = 0;
  std::uint64_t page_bytes = 0;  // without atlases

  [[nodiscard]] std::uint64_t of(std::uint64_t count, std::uint64_t bytes) const {
    return static_cast<std::uint64_t>(static_cast<double>(bytes) * static_cast<double>(count) /
                                      static_cast<double>(std::max<std::uint64_t>(triangles, 1)));
  }
};

std::uint64_t coded_bytes(const DiskParts& parts) {  // without frames and atlases
  return parts.mesh + parts.bvh.tree + parts.bvh.materials + parts.bvh.appearances + parts.bvh.light +
         parts.bvh.normals;
}

}  // namespace

std::vector<LeftOut> count_left_out(const WorldIndex& index, const DiskParts& proxies, const DiskParts& detail,
                                    const LeftOutInput& input) {
  Sum of_proxies, of_detail;
  LeftOut normals{"triangles without normals of their own"};
  LeftOut texcoords{"triangles without texture coordinates"};
  LeftOut light{"zones without light, which all of the sky reaches"};
  LeftOut atlases{"atlases, or parts of them, that would show mean colours"};
  for (std::size_t i = 0; i < index.nodes.size(); ++i) {
    const NodeRecord& node = index.nodes[i];
    Sum& sum = node.is_detail() ? of_detail : of_proxies;
    sum.triangles += node.triangle_count;
    sum.page_bytes += node.page_bytes - node.texture_bytes;

    const std::uint64_t flat = node.reference_count - node.normal_bytes / sizeof(gpu::TriangleNormals);
    normals.count += flat;
    normals.page_bytes += sizeof(gpu::TriangleNormals) * flat;
    texcoords.count += node.reference_count;
    texcoords.page_bytes += kTexcoordBytes * node.reference_count;
    texcoords.page_bytes -= std::min<std::uint64_t>(node.appearance_bytes, texcoords.page_bytes);
    if (input.light && node.light_bytes == 0) {
      ++light.count;
      light.page_bytes += sizeof(gpu::TriangleLight) * std::uint64_t{node.reference_count};
    }
    if (input.atlas_sizes.empty()) continue;
    const std::uint64_t whole = atlas_bytes(input.atlas_sizes[i]);
    if (node.texture_bytes >= whole) continue;
    ++atlases.count;
    atlases.page_bytes += whole - node.texture_bytes;
  }
  const LeftOut faces{"faces that can be seen from nowhere outside", input.interior_faces,
                      of_detail.of(input.interior_faces, of_detail.page_bytes),
                      of_detail.of(input.interior_faces, coded_bytes(detail))};
  const LeftOut levels{"levels of zones that save too little", input.levels,
                       of_proxies.of(input.level_triangles, of_proxies.page_bytes),
                       of_proxies.of(input.level_triangles, coded_bytes(proxies))};
  std::vector<LeftOut> out = {faces, levels, normals, texcoords, light, atlases};
  std::erase_if(out, [](const LeftOut& left) { return left.count == 0; });
  return out;
}

}  // namespace zc
