// SPDX-License-Identifier: Apache-2.0
// Packing and unpacking the boxes of a PageNode, for C++: the baker writes nodes, the loader checks them and the
// runtime builds the top level out of them. Boxes are inclusive, in world lattice units; packing rounds outwards, so
// that a box read back contains the box that was written. Source: Ylitie, Karras & Laine 2017, section 3.1.
// Thread-safe: no state.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <span>

#include "shaders/shared/page.h"

namespace zc {

struct NodeBox {
  std::array<std::int32_t, 3> min = {std::numeric_limits<std::int32_t>::max(), std::numeric_limits<std::int32_t>::max(),
                                     std::numeric_limits<std::int32_t>::max()};
  std::array<std::int32_t, 3> max = {std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::min(),
                                     std::numeric_limits<std::int32_t>::min()};

  [[nodiscard]] bool empty() const { return min[0] > max[0]; }
  void add(const NodeBox& b) {
    for (std::size_t i = 0; i < 3; ++i) {
      min[i] = std::min(min[i], b.min[i]);
      max[i] = std::max(max[i], b.max[i]);
    }
  }
  // Half the surface.
  [[nodiscard]] double half_area() const {
    if (empty()) return 0;
    const double x = static_cast<double>(max[0]) - min[0];
    const double y = static_cast<double>(max[1]) - min[1];
    const double z = static_cast<double>(max[2]) - min[2];
    return x * y + y * z + z * x;
  }
};

inline constexpr std::uint32_t kNodeExponentMax = 31;

[[nodiscard]] inline std::uint32_t node_exponent(const gpu::PageNode& node, std::size_t axis) {
  return node.exponents_masks >> (5 * axis) & 31U;
}
[[nodiscard]] inline std::uint32_t inner_mask(const gpu::PageNode& node) { return node.exponents_masks >> 16 & 0xFFU; }
[[nodiscard]] inline std::uint32_t leaf_mask(const gpu::PageNode& node) { return node.exponents_masks >> 24; }
[[nodiscard]] inline std::uint32_t leaf_count(const gpu::PageNode& node, std::uint32_t slot) {
  return node.leaf_counts >> (4 * slot) & 15U;
}

// The twelve words of box planes: lower x (slots 0-3, 4-7), y, z, then upper.
[[nodiscard]] inline std::array<std::uint32_t, 12> node_planes(const gpu::PageNode& n) {
  return {n.min_x_0, n.min_x_4, n.min_y_0, n.min_y_4, n.min_z_0, n.min_z_4,
          n.max_x_0, n.max_x_4, n.max_y_0, n.max_y_4, n.max_z_0, n.max_z_4};
}

// In 64 bits, because a node from a file may say anything.
struct WideNodeBox {
  std::array<std::int64_t, 3> min;
  std::array<std::int64_t, 3> max;
};
[[nodiscard]] inline WideNodeBox child_box(const gpu::PageNode& node, std::uint32_t slot) {
  const std::array<std::uint32_t, 12> planes = node_planes(node);
  const std::array<std::int32_t, 3> origin = {node.origin_x, node.origin_y, node.origin_z};
  WideNodeBox box{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::uint32_t e = node_exponent(node, axis);
    const std::uint32_t shift = 8 * (slot & 3U);
    const std::int64_t low = planes[2 * axis + slot / 4] >> shift & 0xFFU;
    const std::int64_t high = planes[6 + 2 * axis + slot / 4] >> shift & 0xFFU;
    box.min[axis] = origin[axis] + (low << e);
    box.max[axis] = origin[axis] + (high << e);
  }
  return box;
}

// The slots in `used` as one box, within 32 bits: verify_page sees to it that they are.
[[nodiscard]] inline NodeBox bounds_of_slots(const gpu::PageNode& node, std::uint32_t used) {
  NodeBox all;
  for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
    if ((used >> slot & 1U) == 0) continue;
    const WideNodeBox box = child_box(node, slot);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      all.min[axis] = static_cast<std::int32_t>(std::min<std::int64_t>(all.min[axis], box.min[axis]));
      all.max[axis] = static_cast<std::int32_t>(std::max<std::int64_t>(all.max[axis], box.max[axis]));
    }
  }
  return all;
}

// A node whose slots have these boxes (empty ones: no child), without masks and references. Extents stay below 2^31.
// The grid is aligned to multiples of its step in the world, so that a child's grid nests in its parent's and a child's
// rounded boxes stay in the box that its parent has for it.
[[nodiscard]] inline gpu::PageNode pack_boxes(const std::array<NodeBox, gpu::kNodeWidth>& boxes) {
  NodeBox all;
  for (const NodeBox& box : boxes)
    if (!box.empty()) all.add(box);
  if (all.empty()) all = {{0, 0, 0}, {0, 0, 0}};
  const auto down = [](std::int64_t v, std::uint32_t e) { return v >> e; };
  const auto up = [](std::int64_t v, std::uint32_t e) { return (v + (std::int64_t{1} << e) - 1) >> e; };
  std::array<std::uint32_t, 12> planes{};
  std::array<std::int32_t, 3> origin{};
  std::uint32_t exponents = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto extent = static_cast<std::uint64_t>(std::int64_t{all.max[axis]} - all.min[axis]);
    std::uint32_t e = extent > 255 ? static_cast<std::uint32_t>(std::bit_width(extent)) - 8 : 0;  // no less would do
    while (up(all.max[axis], e) - down(all.min[axis], e) > 255) ++e;
    exponents |= e << (5 * axis);
    const std::int64_t base = down(all.min[axis], e);
    origin[axis] = static_cast<std::int32_t>(base << e);
    // From the grid's first plane, where no number is negative.
    const auto from = [&](std::int32_t v) { return static_cast<std::uint64_t>(v - (base << e)); };
    for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
      const bool used = !boxes[slot].empty();
      const auto low = used ? static_cast<std::uint32_t>(from(boxes[slot].min[axis]) >> e) : 255U;
      const auto high =
          used ? static_cast<std::uint32_t>((from(boxes[slot].max[axis]) + (std::uint64_t{1} << e) - 1) >> e) : 0U;
      planes[2 * axis + slot / 4] |= low << (8 * (slot & 3U));
      planes[6 + 2 * axis + slot / 4] |= high << (8 * (slot & 3U));
    }
  }
  gpu::PageNode node{};
  node.origin_x = origin[0];
  node.origin_y = origin[1];
  node.origin_z = origin[2];
  node.exponents_masks = exponents;
  node.min_x_0 = planes[0], node.min_x_4 = planes[1], node.min_y_0 = planes[2], node.min_y_4 = planes[3];
  node.min_z_0 = planes[4], node.min_z_4 = planes[5], node.max_x_0 = planes[6], node.max_x_4 = planes[7];
  node.max_y_0 = planes[8], node.max_y_4 = planes[9], node.max_z_0 = planes[10], node.max_z_4 = planes[11];
  return node;
}

// Which child goes to which slot, so that `slot ^ octant` is roughly front to back for rays of every octant (bit a of
// the octant: the ray runs backwards along axis a): greedily by how far a child's centre lies towards a slot's corner.
// Returns the child in each slot, or -1. At most eight children.
[[nodiscard]] inline std::array<int, gpu::kNodeWidth> assign_slots(std::span<const NodeBox> children) {
  std::array<int, gpu::kNodeWidth> child_of_slot;
  child_of_slot.fill(-1);
  NodeBox all;
  for (const NodeBox& box : children) all.add(box);
  std::array<std::array<std::int64_t, 3>, gpu::kNodeWidth> center{};  // doubled, from the middle of all
  for (std::size_t c = 0; c < children.size(); ++c)
    for (std::size_t axis = 0; axis < 3; ++axis)
      center[c][axis] = std::int64_t{children[c].min[axis]} + children[c].max[axis] - all.min[axis] - all.max[axis];
  // The free slot that each child would have, and how much it wants it; of equal slots the first. That is the corner it
  // lies towards, unless another child has it already.
  std::array<std::int64_t, gpu::kNodeWidth> want{};
  std::array<std::size_t, gpu::kNodeWidth> wanted{};
  constexpr std::int64_t kPlaced = std::numeric_limits<std::int64_t>::min();
  for (std::size_t c = 0; c < children.size(); ++c) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      want[c] += std::abs(center[c][axis]);
      wanted[c] |= (center[c][axis] > 0 ? std::size_t{1} : 0) << axis;
    }
  }
  for (std::size_t round = 0; round < children.size(); ++round) {
    std::size_t best = 0;
    for (std::size_t c = 1; c < children.size(); ++c)
      if (want[c] > want[best]) best = c;
    const std::size_t taken = wanted[best];
    child_of_slot[taken] = static_cast<int>(best);
    want[best] = kPlaced;
    for (std::size_t c = 0; c < children.size(); ++c) {
      if (want[c] == kPlaced || wanted[c] != taken) continue;
      want[c] = kPlaced;
      for (std::size_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
        std::int64_t towards = 0;
        for (std::size_t axis = 0; axis < 3; ++axis)
          towards += (slot >> axis & 1U) != 0 ? center[c][axis] : -center[c][axis];
        if (child_of_slot[slot] >= 0 || towards <= want[c]) continue;
        want[c] = towards;
        wanted[c] = slot;
      }
    }
  }
  return child_of_slot;
}

}  // namespace zc
