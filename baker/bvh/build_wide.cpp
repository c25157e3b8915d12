// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/bvh/build_wide.h"

#include <string>

#include "baker/bvh/binned_sah.h"
#include "base/check.h"

namespace zc {

Result<WideTree> build_wide_bvh(std::span<const BvhTriangle> triangles, const BvhBuildOptions& options) {
  if (triangles.empty()) return Error{ErrorCode::kFormat, "a zone without triangles has no BVH"};
  if (triangles.size() > gpu::kPageMaxTriangles)
    return Error{ErrorCode::kUnsupported,
                 "a zone has " + std::to_string(triangles.size()) + " triangles, more than a page can number"};
  std::vector<BvhReference> references(triangles.size());
  for (std::uint32_t i = 0; i < triangles.size(); ++i) references[i] = {box_of(triangles[i]), i};
  const BinaryTree binary = build_binned_sah(std::move(references));
  WideTree tree = collapse(binary, options.collapse);
  if (tree.depth > gpu::kPageMaxDepth) {
    CollapseOptions by_levels = options.collapse;
    by_levels.by_levels = true;
    tree = collapse(binary, by_levels);
  }
  static_assert((kBinaryDepthMax - 1 + 2) / 3 <= gpu::kPageMaxDepth);
  ZC_CHECK(tree.depth <= gpu::kPageMaxDepth);
  return tree;
}

}  // namespace zc
