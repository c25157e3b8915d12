// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/bvh/page_nodes.h"

#include <algorithm>
#include <span>
#include <utility>

#include "base/check.h"
#include "shaders/shared/page_node.h"
#include "streamer/world_format/cluster_tables.h"
#include "streamer/world_format/leaf_boxes.h"

namespace zc {
namespace {

class Layout {
 public:
  Layout(const WideTree& tree, const ZoneMesh& mesh, ZoneAppearance&& appearance, const NodeRecord& record)
      : tree_(tree), mesh_(mesh), record_(record) {
    out_.appearance = std::move(appearance);
  }

  BvhFile run() {
    out_.depth = tree_.depth;
    out_.split = tree_.references.size() > mesh_.triangles.size();
    out_.nodes.resize(tree_.nodes.size());
    out_.order.reserve(tree_.references.size());
    out_.clusters.push_back(0);
    visit(0);
    ZC_CHECK(out_.order.size() == tree_.references.size());
    const std::vector<std::uint8_t> cut = leaves_with_pieces(out_);
    for (std::uint32_t i = 0; i < cut.size(); ++i)
      for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
        if ((cut[i] >> slot & 1U) == 0) continue;
        const BvhBox& box = tree_.nodes[i].slots[slot].box;
        out_.trims.push_back(trim_to(box_of_leaf(out_, mesh_, i, slot), {box.min, box.max}));
      }
    ZC_CHECK(fit_boxes(out_, mesh_, record_, {}).ok());
    return std::move(out_);
  }

 private:
  void visit(std::uint32_t index) {
    const WideNode& wide = tree_.nodes[index];
    gpu::PageNode node{};
    triangles_.clear();
    for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
      const WideChild& child = wide.slots[slot];
      if (child.kind == WideChild::Kind::kNode) {
        if (inner_mask(node) == 0) node.child_offset = child.first;
        node.exponents_masks |= 1U << (16 + slot);
      } else if (child.kind == WideChild::Kind::kLeaf) {
        node.exponents_masks |= 1U << (24 + slot);
        node.leaf_counts |= child.count << (4 * slot);
        const std::size_t first = triangles_.size();
        for (const BvhReference& r : std::span(tree_.references).subspan(child.first, child.count))
          triangles_.push_back(r.triangle);
        std::sort(triangles_.begin() + static_cast<std::ptrdiff_t>(first), triangles_.end());  // as the file has them
      }
    }
    if (!triangles_.empty()) {
      node.triangle_offset = static_cast<std::uint32_t>(out_.order.size());
      append();
      node.cluster_offset = static_cast<std::uint32_t>(out_.clusters.size()) - 1;
    }
    out_.nodes[index] = node;
    for (const WideChild& child : wide.slots)
      if (child.kind == WideChild::Kind::kNode) visit(child.first);
  }

  // All of a node's triangles go into one cluster: a new one when the present one has no room for them, their vertices
  // or their materials or appearances.
  void append() {
    if (!try_add()) {
      out_.clusters.push_back(static_cast<std::uint32_t>(out_.order.size()));
      vertices_.clear();
      palette_.clear();
      ZC_CHECK(try_add());  // at most 96 vertices
    }
    out_.order.insert(out_.order.end(), triangles_.begin(), triangles_.end());
  }

  bool try_add() {
    if (out_.order.size() - out_.clusters.back() + triangles_.size() > gpu::kClusterMaxTriangles) return false;
    const std::vector<std::uint16_t>& appearances = out_.appearance.appearance_of;
    for (const std::uint32_t t : triangles_) {
      if (!palette_.add(appearances.empty() ? mesh_.materials[t] : appearances[t])) return false;
      for (const std::uint32_t v : mesh_.triangles[t])
        if (!vertices_.add(mesh_.vertices[v])) return false;
    }
    return true;
  }

  const WideTree& tree_;
  const ZoneMesh& mesh_;
  const NodeRecord& record_;
  BvhFile out_;
  std::vector<std::uint32_t> triangles_;  // of the node's leaves
  ClusterVertices vertices_;
  ClusterPalette palette_;
};

}  // namespace

BvhFile lay_out_bvh(const WideTree& tree, const ZoneMesh& mesh, ZoneAppearance appearance, const NodeRecord& record) {
  return Layout(tree, mesh, std::move(appearance), record).run();
}

}  // namespace zc
