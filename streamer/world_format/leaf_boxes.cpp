// SPDX-License-Identifier: Apache-2.0
#include "streamer/world_format/leaf_boxes.h"

#include <algorithm>
#include <bit>

#include "shaders/shared/page_node.h"

namespace zc {
namespace {

LeafBox trimmed(const LeafBox& whole, const LeafTrim& trim) {
  LeafBox box = whole;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto extent = static_cast<std::uint32_t>(whole.max[axis] - whole.min[axis]);
    box.min[axis] = static_cast<std::uint16_t>(whole.min[axis] + extent * trim[axis] / kLeafTrimParts);
    box.max[axis] = static_cast<std::uint16_t>(whole.max[axis] - extent * trim[3 + axis] / kLeafTrimParts);
  }
  return box;
}

// Empty beyond the lattice's 32 bits, where verify_page would find its triangles.
NodeBox to_world(const LeafBox& box, const NodeRecord& record) {
  NodeBox world;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t low = record.origin[axis] + (std::int64_t{box.min[axis]} << record.step_shift);
    const std::int64_t high = record.origin[axis] + (std::int64_t{box.max[axis]} << record.step_shift);
    if (high > INT32_MAX) return {};
    world.min[axis] = static_cast<std::int32_t>(low);
    world.max[axis] = static_cast<std::int32_t>(high);
  }
  return world;
}

std::span<const std::uint32_t> triangles_of(const BvhFile& bvh, std::uint32_t node, std::uint32_t slot) {
  std::uint32_t first = bvh.nodes[node].triangle_offset;
  for (std::uint32_t s = 0; s < slot; ++s) first += leaf_count(bvh.nodes[node], s);
  return std::span(bvh.order).subspan(first, leaf_count(bvh.nodes[node], slot));
}

// Whether each triangle is in several leaves.
std::vector<bool> split_triangles(const BvhFile& bvh) {
  const std::uint32_t most = bvh.order.empty() ? 0 : *std::ranges::max_element(bvh.order);
  std::vector<bool> seen(std::size_t{most} + 1);
  std::vector<bool> split(seen.size());
  for (const std::uint32_t triangle : bvh.order) {
    if (seen[triangle]) split[triangle] = true;
    seen[triangle] = true;
  }
  return split;
}

}  // namespace

std::vector<std::uint8_t> leaves_with_pieces(const BvhFile& bvh) {
  std::vector<std::uint8_t> masks(bvh.nodes.size());
  if (!bvh.split) return masks;
  const std::vector<bool> split = split_triangles(bvh);
  for (std::uint32_t i = 0; i < masks.size(); ++i)
    for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot)
      if (std::ranges::any_of(triangles_of(bvh, i, slot), [&](std::uint32_t t) { return split[t]; }))
        masks[i] = static_cast<std::uint8_t>(masks[i] | 1U << slot);
  return masks;
}

std::size_t count_leaves(std::span<const std::uint8_t> masks) {
  std::size_t count = 0;
  for (const std::uint8_t mask : masks) count += static_cast<std::size_t>(std::popcount(mask));
  return count;
}

LeafBox box_of_leaf(const BvhFile& bvh, const ZoneMesh& mesh, std::uint32_t node, std::uint32_t slot) {
  LeafBox box;
  for (const std::uint32_t triangle : triangles_of(bvh, node, slot))
    for (const std::uint32_t v : mesh.triangles[triangle])
      for (std::size_t axis = 0; axis < 3; ++axis) {
        box.min[axis] = std::min(box.min[axis], mesh.vertices[v][axis]);
        box.max[axis] = std::max(box.max[axis], mesh.vertices[v][axis]);
      }
  return box;
}

LeafTrim trim_to(const LeafBox& whole, const LeafBox& part) {
  const auto parts = [](std::uint32_t distance, std::uint32_t extent) {
    return extent == 0 ? std::uint8_t{0}
                       : static_cast<std::uint8_t>(std::min(distance * kLeafTrimParts / extent, kLeafTrimParts - 1));
  };
  LeafTrim trim{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto extent = static_cast<std::uint32_t>(whole.max[axis] - whole.min[axis]);
    trim[axis] = parts(static_cast<std::uint32_t>(std::max(part.min[axis] - whole.min[axis], 0)), extent);
    trim[3 + axis] = parts(static_cast<std::uint32_t>(std::max(whole.max[axis] - part.max[axis], 0)), extent);
  }
  return trim;
}

Status fit_boxes(BvhFile& bvh, const ZoneMesh& mesh, const NodeRecord& record, const std::string& path) {
  const std::vector<std::uint8_t> cut = leaves_with_pieces(bvh);
  if (bvh.trims.size() != count_leaves(cut)) return Error{ErrorCode::kFormat, "not every cut leaf has its box", path};
  for (const LeafTrim& trim : bvh.trims)
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (trim[axis] + trim[3 + axis] > kLeafTrimParts)
        return Error{ErrorCode::kFormat, "nothing is left of a cut leaf's box", path};
  std::vector<NodeBox> whole(bvh.nodes.size());                            // of all that is below a node
  std::size_t next = bvh.trims.size();                                     // behind the trims of the nodes to come
  for (auto i = static_cast<std::uint32_t>(bvh.nodes.size()); i-- > 0;) {  // children lie behind their parents
    gpu::PageNode& node = bvh.nodes[i];
    std::array<NodeBox, gpu::kNodeWidth> boxes;
    for (std::uint32_t slot = gpu::kNodeWidth; slot-- > 0;) {
      if ((leaf_mask(node) >> slot & 1U) == 0) continue;
      LeafBox box = box_of_leaf(bvh, mesh, i, slot);
      if ((cut[i] >> slot & 1U) != 0) box = trimmed(box, bvh.trims[--next]);
      boxes[slot] = to_world(box, record);
      if (boxes[slot].empty()) return Error{ErrorCode::kFormat, "a triangle leaves the lattice", path};
    }
    std::uint32_t child = node.child_offset;
    for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot)
      if ((inner_mask(node) >> slot & 1U) != 0) boxes[slot] = whole[child++];
    for (const NodeBox& box : boxes)
      if (!box.empty()) whole[i].add(box);
    gpu::PageNode packed = pack_boxes(boxes);
    packed.exponents_masks |= node.exponents_masks & 0xFFFF0000U;
    packed.child_offset = node.child_offset;
    packed.triangle_offset = node.triangle_offset;
    packed.leaf_counts = node.leaf_counts;
    packed.cluster_offset = node.cluster_offset;
    node = packed;
  }
  return {};
}

}  // namespace zc
