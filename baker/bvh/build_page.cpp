// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/bvh/build_page.h"

#include <utility>

#include "baker/bvh/page_nodes.h"
#include "streamer/world_format/page_view.h"

namespace zc {

std::vector<BvhTriangle> bvh_triangles(const ZoneMesh& mesh) {
  std::vector<BvhTriangle> triangles(mesh.triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) triangles[i][k] = mesh.vertices[mesh.triangles[i][k]];
  return triangles;
}

Result<BuiltPage> build_page(const ZoneMesh& mesh, ZoneAppearance appearance, const BvhBuildOptions& options,
                             std::uint32_t material_count, NodeRecord& node, const std::string& name) {
  ZC_ASSIGN(const WideTree tree, build_wide_bvh(bvh_triangles(mesh), options));
  return lay_out_page(tree, mesh, std::move(appearance), material_count, node, name);
}

Result<BuiltPage> lay_out_page(const WideTree& tree, const ZoneMesh& mesh, ZoneAppearance appearance,
                               std::uint32_t material_count, NodeRecord& node, const std::string& name) {
  BuiltPage page;
  page.bvh = lay_out_bvh(tree, mesh, std::move(appearance), node);
  node.bvh_node_count = static_cast<std::uint32_t>(page.bvh.nodes.size());
  node.reference_count = static_cast<std::uint32_t>(page.bvh.order.size());
  node.bvh_depth = page.bvh.depth;
  node.page_bytes = 0;
  ZC_ASSIGN(page.words, assemble_page(mesh, page.bvh, node, material_count, name));
  node.page_bytes = static_cast<std::uint32_t>(4 * page.words.size());
  const PageView::Parts parts = PageView(page.words).parts();
  node.appearance_bytes = parts.appearance_bytes;
  node.light_bytes = parts.light_bytes;
  node.normal_bytes = parts.normal_bytes;
  node.texture_bytes = parts.texture_bytes;
  return page;
}

}  // namespace zc
