// SPDX-License-Identifier: Apache-2.0
#include "replay/bench/engines/plain_layout.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

#include "shaders/shared/page_node.h"
#include "streamer/world_format/page_view.h"

namespace zc::bench {
namespace {

constexpr std::uint32_t kPlaneNodeWords = 56;
constexpr std::uint32_t kChildNodeWords = 64;
constexpr std::uint32_t kTriangleWords = 12;

std::uint32_t bits_of(float value) { return std::bit_cast<std::uint32_t>(value); }
std::uint32_t bits_of(std::int32_t steps) { return bits_of(static_cast<float>(steps)); }

struct PoolTriangle {
  std::uint32_t word = 0;  // its own; triangles are numbered in this order, as pages number theirs
  PlainTriangle place;
  std::array<PageView::Point, 3> corners;
};

struct TreeNode {
  std::uint32_t word = 0;
  gpu::PageNode node;
  std::array<NodeBox, gpu::kNodeWidth> boxes;
  float error_m = 0;  // of the zone that its triangles are of
};

// What a page's box is rounded from: `tight`, within `rounded`, because a leaf may hold but a part of its triangles.
NodeBox within(const NodeBox& tight, const WideNodeBox& rounded) {
  NodeBox box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.min[axis] = std::max(tight.min[axis], static_cast<std::int32_t>(rounded.min[axis]));
    box.max[axis] = std::min(tight.max[axis], static_cast<std::int32_t>(rounded.max[axis]));
  }
  return box;
}

class Tree {
 public:
  Tree(std::span<const std::uint32_t> pool, std::uint32_t root_word) : pool_(pool) {
    visit(root_word);
    // The top level first, so that the root is node 0.
    std::ranges::sort(nodes, {}, [&](const TreeNode& n) { return n.word - root_word; });
    std::ranges::sort(triangles, {}, &PoolTriangle::word);
  }
  [[nodiscard]] std::uint32_t node_number(std::uint32_t word) const {
    const std::uint32_t root_word = nodes.front().word;
    const auto at =
        std::ranges::lower_bound(nodes, word - root_word, {}, [&](const TreeNode& n) { return n.word - root_word; });
    return static_cast<std::uint32_t>(at - nodes.begin());
  }
  [[nodiscard]] std::uint32_t triangle_number(std::uint32_t word) const {
    return static_cast<std::uint32_t>(std::ranges::lower_bound(triangles, word, {}, &PoolTriangle::word) -
                                      triangles.begin());
  }

  std::vector<TreeNode> nodes;
  std::vector<PoolTriangle> triangles;

 private:
  NodeBox visit(std::uint32_t word) {
    TreeNode tree_node{word, page_record<gpu::PageNode>(pool_, word), {}};
    const gpu::PageNode& node = tree_node.node;
    if (leaf_mask(node) != 0)
      tree_node.error_m = page_record<gpu::ClusterHeader>(pool_, word + node.cluster_offset).error_m;
    std::uint32_t child_word = word + node.child_offset;
    std::uint32_t triangle_word = word + node.triangle_offset;
    NodeBox all;
    for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
      NodeBox& box = tree_node.boxes[slot];
      if ((inner_mask(node) >> slot & 1U) != 0) {
        box = visit(child_word);
        child_word += gpu::kPageNodeWords;
      } else if ((leaf_mask(node) >> slot & 1U) != 0) {
        for (std::uint32_t i = 0; i < leaf_count(node, slot); ++i)
          box.add(add_triangle(triangle_word++, word + node.cluster_offset));
      } else {
        continue;
      }
      box = within(box, child_box(node, slot));
      all.add(box);
    }
    nodes.push_back(tree_node);
    return all;
  }

  NodeBox add_triangle(std::uint32_t word, std::uint32_t cluster_word) {
    const auto cluster = page_record<gpu::ClusterHeader>(pool_, cluster_word);
    PoolTriangle triangle;
    triangle.word = word;
    triangle.place = {cluster_word - cluster.page_back_words,
                      cluster.first_triangle + word - cluster_word - gpu::kClusterHeaderWords};
    triangle.corners = PageView(pool_.subspan(triangle.place.page_word)).triangle(triangle.place.position).corners;
    triangles.push_back(triangle);
    NodeBox box;
    for (const PageView::Point& corner : triangle.corners) box.add({corner, corner});
    return box;
  }

  std::span<const std::uint32_t> pool_;
};

// A slot without a child is a box that no ray hits.
std::array<std::uint32_t, 6> planes_of(const NodeBox& box) {
  if (box.empty()) {
    constexpr float kFar = std::numeric_limits<float>::max();
    return {bits_of(kFar), bits_of(kFar), bits_of(kFar), bits_of(-kFar), bits_of(-kFar), bits_of(-kFar)};
  }
  return {bits_of(box.min[0]), bits_of(box.min[1]), bits_of(box.min[2]),
          bits_of(box.max[0]), bits_of(box.max[1]), bits_of(box.max[2])};
}

// references: of nodes, of triangles, and the zone's error.
void write_node(const TreeNode& node, const std::array<std::uint32_t, 5>& references, PlainNodes form,
                std::span<std::uint32_t> out) {
  for (std::uint32_t i = 0; i < references.size(); ++i)
    out[form == PlainNodes::kByChild ? 8 * i + 3 : i < 4 ? i : 52] = references[i];
  for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
    const std::array<std::uint32_t, 6> planes = planes_of(node.boxes[slot]);
    for (std::uint32_t plane = 0; plane < 6; ++plane) {
      const std::uint32_t at = form == PlainNodes::kByPlane ? 4 + 8 * plane + slot : 8 * slot + plane + plane / 3;
      out[at] = planes[plane];
    }
  }
}

}  // namespace

PlainPool make_plain_pool(std::span<const std::uint32_t> pool, std::uint32_t root_word, PlainNodes form) {
  const Tree tree(pool, root_word);
  const std::uint32_t node_words = form == PlainNodes::kByPlane ? kPlaneNodeWords : kChildNodeWords;
  const auto node_count = static_cast<std::uint32_t>(tree.nodes.size());
  PlainPool plain;
  plain.first_triangle = (node_count * node_words + kTriangleWords - 1) / kTriangleWords;
  plain.words.resize(std::size_t{kTriangleWords} * (plain.first_triangle + tree.triangles.size()));
  for (std::uint32_t i = 0; i < node_count; ++i) {
    const TreeNode& n = tree.nodes[i];
    const std::uint32_t triangle = plain.first_triangle + tree.triangle_number(n.word + n.node.triangle_offset);
    write_node(
        n,
        {inner_mask(n.node) | leaf_mask(n.node) << 8U, tree.node_number(n.word + n.node.child_offset) * node_words,
         triangle, n.node.leaf_counts, bits_of(n.error_m)},
        form, std::span(plain.words).subspan(std::size_t{i} * node_words, node_words));
  }
  std::size_t at = std::size_t{kTriangleWords} * plain.first_triangle;
  for (const PoolTriangle& triangle : tree.triangles) {
    plain.triangles.push_back(triangle.place);
    for (const PageView::Point& corner : triangle.corners) {
      for (const std::int32_t v : corner) plain.words[at++] = bits_of(v);
      ++at;
    }
  }
  return plain;
}

}  // namespace zc::bench
