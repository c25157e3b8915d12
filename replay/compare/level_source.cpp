// SPDX-License-Identifier: Apache-2.0
#include "replay/compare/level_source.h"

#include <span>

namespace zc {

WorldIndex cut_at_depth(const WorldIndex& index, std::uint32_t depth) {
  WorldIndex cut;
  cut.header = index.header;
  cut.materials = index.materials;
  cut.crs = index.crs;
  // Parents come before children, and siblings lie together: so do those that stay.
  std::vector<std::uint32_t> kept(index.nodes.size(), 0);  // 0: not
  for (std::uint32_t i = 0; i < index.nodes.size(); ++i) {
    NodeRecord node = index.nodes[i];
    if (i > 0) {
      const auto parent = static_cast<std::uint32_t>(node.parent);
      if (parent > 0 && kept[parent] == 0) continue;
      NodeRecord& above = cut.nodes[kept[parent]];
      if (above.child_count == 0) continue;
      if (i == index.nodes[parent].first_child) above.first_child = static_cast<std::uint32_t>(cut.nodes.size());
      node.parent = static_cast<std::int32_t>(kept[parent]);
      kept[i] = static_cast<std::uint32_t>(cut.nodes.size());
    }
    const auto children = std::span(index.nodes).subspan(node.first_child, node.child_count);
    for (const NodeRecord& child : children)
      if (child.is_detail() || child.depth > depth) node.child_count = 0;
    if (node.child_count == 0) node.first_child = 0;
    cut.nodes.push_back(node);
  }
  return cut;
}

}  // namespace zc
