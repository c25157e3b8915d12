// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/bvh/page_nodes.h"

#include <span>
#include <utility>

#include "base/check.h"
#include "shaders/shared/page_node.h"
#include "streamer/world_format/cluster_tables.h"

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
    return std::move(out_);
  }

 private:
  void visit(std::uint32_t index) {
    const WideNode& wide = tree_.nodes[index];
    std::array<NodeBox, gpu::kNodeWidth> boxes;
    for (std::size_t slot = 0; slot < gpu::kNodeWidth; ++slot)
      if (wide.slots[slot].kind != WideChild::Kind::kNone) boxes[slot] = to_world(wide.slots[slot].box);
    gpu::PageNode node = pack_boxes(boxes);

    std::uint32_t first_child = 0;
    std::uint32_t first_reference = 0;
    std::uint32_t references = 0;
    for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
      const WideChild& child = wide.slots[slot];
      if (child.kind == WideChild::Kind::kNode) {
        if (inner_mask(node) == 0) first_child = child.first;
        node.exponents_masks |= 1U << (16 + slot);
      } else if (child.kind == WideChild::Kind::kLeaf) {
        if (references == 0) first_reference = child.first;
        node.exponents_masks |= 1U << (24 + slot);
        node.leaf_counts |= child.count << (4 * slot);
        references += child.count;
      }
    }
    node.child_offset = first_child;
    if (references > 0) {
      node.triangle_offset = static_cast<std::uint32_t>(out_.order.size());
      append(std::span(tree_.references).subspan(first_reference, references));
      node.cluster_offset = static_cast<std::uint32_t>(out_.clusters.size()) - 1;
    }
    out_.nodes[index] = node;
    for (const WideChild& child : wide.slots)
      if (child.kind == WideChild::Kind::kNode) visit(child.first);
  }

  [[nodiscard]] NodeBox to_world(const BvhBox& box) const {
    NodeBox world;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      world.min[axis] = record_.origin[axis] + (std::int32_t{box.min[axis]} << record_.step_shift);
      world.max[axis] = record_.origin[axis] + (std::int32_t{box.max[axis]} << record_.step_shift);
    }
    return world;
  }

  // All of a node's triangles go into one cluster: a new one when the present one has no room for them, their vertices
  // or their materials or looks.
  void append(std::span<const BvhReference> references) {
    if (!try_add(references)) {
      out_.clusters.push_back(static_cast<std::uint32_t>(out_.order.size()));
      vertices_.clear();
      palette_.clear();
      ZC_CHECK(try_add(references));  // at most 96 vertices
    }
    for (const BvhReference& r : references) out_.order.push_back(r.triangle);
  }

  bool try_add(std::span<const BvhReference> references) {
    if (out_.order.size() - out_.clusters.back() + references.size() > gpu::kClusterMaxTriangles) return false;
    const std::vector<std::uint16_t>& looks = out_.appearance.look_of;
    for (const BvhReference& r : references) {
      if (!palette_.add(looks.empty() ? mesh_.materials[r.triangle] : looks[r.triangle])) return false;
      for (const std::uint32_t v : mesh_.triangles[r.triangle])
        if (!vertices_.add(mesh_.vertices[v])) return false;
    }
    return true;
  }

  const WideTree& tree_;
  const ZoneMesh& mesh_;
  const NodeRecord& record_;
  BvhFile out_;
  ClusterVertices vertices_;
  ClusterPalette palette_;
};

}  // namespace

BvhFile lay_out_bvh(const WideTree& tree, const ZoneMesh& mesh, ZoneAppearance appearance, const NodeRecord& record) {
  return Layout(tree, mesh, std::move(appearance), record).run();
}

}  // namespace zc
