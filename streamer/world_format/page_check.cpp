// SPDX-License-Identifier: Apache-2.0
// verify_page: after it, a traversal of the page with a stack of kPageMaxDepth stays in the page and ends.
#include <algorithm>
#include <array>
#include <cstring>

#include "streamer/world_format/bvh_page.h"

namespace zc {
namespace {

using Point = std::array<std::uint32_t, 3>;

struct Box {
  Point low = {0xFFFF, 0xFFFF, 0xFFFF};
  Point high = {0, 0, 0};

  void grow(const Point& point) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], point[axis]);
      high[axis] = std::max(high[axis], point[axis]);
    }
  }
  [[nodiscard]] bool contains(const Box& other) const {
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (other.low[axis] < low[axis] || other.high[axis] > high[axis]) return false;
    return true;
  }
};

Box unpack_box(std::uint32_t min_xy, std::uint32_t min_z_max_x, std::uint32_t max_yz) {
  return {{min_xy & 0xFFFFU, min_xy >> 16U, min_z_max_x & 0xFFFFU},
          {min_z_max_x >> 16U, max_yz & 0xFFFFU, max_yz >> 16U}};
}

// A node's two children: box and reference.
struct Child {
  Box box;
  std::uint32_t ref;
};
std::array<Child, 2> children(const gpu::BvhNode& node) {
  return {Child{unpack_box(node.min0_xy, node.min0_z_max0_x, node.max0_yz), node.ref0},
          Child{unpack_box(node.min1_xy, node.min1_z_max1_x, node.max1_yz), node.ref1}};
}

class PageCheck {
 public:
  PageCheck(std::span<const std::uint32_t> page, const std::string& path) : page_(page), path_(path) {}

  Status run(std::uint32_t material_count) {
    ZC_TRY(check_header());
    node_seen_.assign(header_.node_count, false);
    triangle_seen_.assign(header_.triangle_count, false);
    ZC_TRY(walk());
    if (nodes_met_ != header_.node_count) return fault("a node is not part of the tree", header_.node_offset_words);
    if (triangles_met_ != header_.triangle_count)
      return fault("a triangle is in no leaf", header_.triangle_offset_words);
    for (std::uint32_t t = 0; t < header_.triangle_count; ++t)
      if ((triangle_words(t)[4] >> 16U) >= material_count) return fault("material out of range", triangle_word(t) + 4);
    return {};
  }

 private:
  [[nodiscard]] Error fault(const char* cause, std::size_t word) const {
    return {ErrorCode::kFormat, std::string("page: ") + cause + " (word " + std::to_string(word) + ")", path_};
  }

  Status check_header() {
    if (page_.size() < gpu::kPageHeaderWords) return fault("too short", page_.size());
    std::memcpy(&header_, page_.data(), sizeof header_);
    if (header_.magic != gpu::kPageMagic) return fault("wrong magic", 0);
    if (header_.node_count == 0 || header_.node_count > gpu::kRefFirstMask) return fault("node count out of range", 1);
    if (header_.triangle_count == 0 || header_.triangle_count > gpu::kRefFirstMask)
      return fault("triangle count out of range", 2);
    const std::uint64_t triangles_at = gpu::kPageHeaderWords + std::uint64_t{gpu::kBvhNodeWords} * header_.node_count;
    const std::uint64_t total = triangles_at + std::uint64_t{gpu::kPageTriangleWords} * header_.triangle_count;
    if (total != page_.size() || header_.total_words != total) return fault("size does not follow from its counts", 6);
    if (header_.node_offset_words != gpu::kPageHeaderWords || header_.triangle_offset_words != triangles_at)
      return fault("a part is not where it belongs", 3);
    if (header_.depth == 0 || header_.depth > gpu::kPageMaxDepth) return fault("depth out of range", 5);
    if (header_.reserved != 0) return fault("a reserved word is not zero", 7);
    return {};
  }

  // Depth first; each node is entered once, so this is linear however the references are laid.
  Status walk() {
    struct Entry {
      std::uint32_t node;
      std::uint32_t depth;
    };
    // Each level leaves at most one sibling behind.
    std::array<Entry, gpu::kPageMaxDepth + 1> stack;
    std::size_t top = 0;
    stack[top++] = {0, 1};
    node_seen_[0] = true;
    nodes_met_ = 1;
    while (top > 0) {
      const Entry entry = stack[--top];
      const std::size_t word = node_word(entry.node);
      if (entry.depth > header_.depth) return fault("deeper than its header says", word);
      const std::array<Child, 2> both = children(node(entry.node));
      // The traversal takes the first child as given: a single child is the first.
      if (both[0].ref == gpu::kRefNone) return fault("a node without a first child", word);
      for (const Child& child : both) {
        if (child.ref == gpu::kRefNone) continue;
        if ((child.ref & gpu::kRefLeaf) != 0) {
          ZC_TRY(check_leaf(child, word));
          continue;
        }
        if (child.ref >= header_.node_count) return fault("child out of range", word);
        if (node_seen_[child.ref]) return fault("a node has two parents", word);
        node_seen_[child.ref] = true;
        ++nodes_met_;
        for (const Child& grandchild : children(node(child.ref)))
          if (grandchild.ref != gpu::kRefNone && !child.box.contains(grandchild.box))
            return fault("a box does not contain its children", word);
        if (entry.depth == header_.depth) return fault("deeper than its header says", word);
        stack[top++] = {child.ref, entry.depth + 1};
      }
    }
    return {};
  }

  Status check_leaf(const Child& leaf, std::size_t word) {
    const std::uint32_t count = (leaf.ref >> gpu::kRefCountShift) & gpu::kRefCountMask;
    const std::uint32_t first = leaf.ref & gpu::kRefFirstMask;
    if (count == 0 || count > gpu::kLeafMaxTriangles) return fault("leaf size out of range", word);
    if (first >= header_.triangle_count || count > header_.triangle_count - first)
      return fault("leaf out of range", word);
    Box content;
    for (std::uint32_t t = first; t < first + count; ++t) {
      if (triangle_seen_[t]) return fault("a triangle is in two leaves", triangle_word(t));
      triangle_seen_[t] = true;
      ++triangles_met_;
      const std::span<const std::uint32_t> w = triangle_words(t);
      content.grow({w[0] & 0xFFFFU, w[0] >> 16U, w[1] & 0xFFFFU});
      content.grow({w[1] >> 16U, w[2] & 0xFFFFU, w[2] >> 16U});
      content.grow({w[3] & 0xFFFFU, w[3] >> 16U, w[4] & 0xFFFFU});
    }
    if (!leaf.box.contains(content)) return fault("a box does not contain its triangles", word);
    return {};
  }

  [[nodiscard]] std::size_t node_word(std::uint32_t i) const {
    return header_.node_offset_words + std::size_t{i} * gpu::kBvhNodeWords;
  }
  [[nodiscard]] std::size_t triangle_word(std::uint32_t i) const {
    return header_.triangle_offset_words + std::size_t{i} * gpu::kPageTriangleWords;
  }
  [[nodiscard]] gpu::BvhNode node(std::uint32_t i) const {
    gpu::BvhNode node;
    std::memcpy(&node, page_.data() + node_word(i), sizeof node);
    return node;
  }
  [[nodiscard]] std::span<const std::uint32_t> triangle_words(std::uint32_t i) const {
    return page_.subspan(triangle_word(i), gpu::kPageTriangleWords);
  }

  std::span<const std::uint32_t> page_;
  const std::string& path_;
  gpu::PageHeader header_ = {};
  std::vector<bool> node_seen_;
  std::vector<bool> triangle_seen_;
  std::uint32_t nodes_met_ = 0;
  std::uint32_t triangles_met_ = 0;
};

}  // namespace

Status verify_page(std::span<const std::uint32_t> page, std::uint32_t material_count, const std::string& path) {
  return PageCheck(page, path).run(material_count);
}

}  // namespace zc
