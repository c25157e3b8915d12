// SPDX-License-Identifier: Apache-2.0
// The boxes of a `.zbvh`'s nodes, which are not in the file: a leaf's is that of its triangles, a node's that of its
// children. Where a leaf contains pieces of triangles that spatial splits cut, its box ends inside theirs, and the file
// says how far. Units: steps of the zone. Thread-safe: no state.
// Untrusted input: fit_boxes checks what the tree and its trims say; the tree's references must be in range before.
// Fails when: a trim leaves nothing of a box, or a triangle leaves the lattice.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "shaders/shared/page_node.h"
#include "streamer/world_format/bvh_page.h"

namespace zc {

struct LeafBox {
  std::array<std::uint16_t, 3> min = {0xFFFF, 0xFFFF, 0xFFFF};
  std::array<std::uint16_t, 3> max = {0, 0, 0};
};

// A triangle that is in several leaves, and the box of its pieces there.
struct PieceOfTriangle {
  std::uint32_t triangle = 0;
  NodeBox box;
};

// A mask of slots for each node: the leaves that contain a triangle which is in others as well.
std::vector<std::uint8_t> leaves_with_pieces(const BvhFile& bvh);
std::size_t count_leaves(std::span<const std::uint8_t> masks);

LeafBox box_of_leaf(const BvhFile& bvh, const ZoneMesh& mesh, std::uint32_t node, std::uint32_t slot);

// The least trim whose box, out of `whole`, still contains `part`.
LeafTrim trim_to(const LeafBox& whole, const LeafBox& part);

// Fills the nodes' boxes. Everything else must be there, a trim for each of leaves_with_pieces among it.
Status fit_boxes(BvhFile& bvh, const ZoneMesh& mesh, const NodeRecord& record, const std::string& path);

}  // namespace zc
