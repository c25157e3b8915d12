// SPDX-License-Identifier: Apache-2.0
// How a `.zbvh` codes its tree: from the root down, in which slot of a node each triangle goes, in the order of the
// decoded mesh. That gives the tree, what its leaves contain and the page's order of triangles at once, and no triangle
// is left out or comes too often. Boxes follow from the triangles (fit_boxes). A slot is likely the one of the triangle
// before, for the decoder's order goes from neighbour to neighbour, and the one of the octant that the triangle lies
// in. Borrows the coder, the mesh, the record and the tree to encode. Threads: one at a time. Untrusted input: the
// record bounds nodes, references and depth. Fails when: the tree has more of them.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "shaders/shared/page_node.h"
#include "streamer/world_format/bvh_page.h"
#include "streamer/world_format/coding/range_coder.h"

namespace zc {

// For the encoder: the triangles below each node of a tree, ascending, each once.
class TreeContents {
 public:
  explicit TreeContents(const BvhFile& bvh) : bvh_(bvh), below_(bvh.nodes.size()) {
    for (std::uint32_t i = static_cast<std::uint32_t>(bvh.nodes.size()); i-- > 0;)
      for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
        const std::span<const std::uint32_t> part = of_slot(i, slot);
        below_[i].insert(below_[i].end(), part.begin(), part.end());
        if (slot + 1 == gpu::kNodeWidth) {
          std::ranges::sort(below_[i]);
          below_[i].erase(std::unique(below_[i].begin(), below_[i].end()), below_[i].end());
        }
      }
  }
  // The slots of a node that a triangle is in.
  [[nodiscard]] std::uint32_t slots_of(std::uint32_t node, std::uint32_t triangle) const {
    std::uint32_t mask = 0;
    for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
      const std::span<const std::uint32_t> part = of_slot(node, slot);
      const bool in_leaf = (leaf_mask(bvh_.nodes[node]) >> slot & 1U) != 0;
      const bool found =
          in_leaf ? std::ranges::find(part, triangle) != part.end() : std::ranges::binary_search(part, triangle);
      mask |= found ? 1U << slot : 0;
    }
    return mask;
  }
  [[nodiscard]] std::uint32_t child(std::uint32_t node, std::uint32_t slot) const {
    const gpu::PageNode& n = bvh_.nodes[node];
    return n.child_offset + static_cast<std::uint32_t>(std::popcount(inner_mask(n) & ((1U << slot) - 1U)));
  }

 private:
  [[nodiscard]] std::span<const std::uint32_t> of_slot(std::uint32_t node, std::uint32_t slot) const {
    const gpu::PageNode& n = bvh_.nodes[node];
    if ((inner_mask(n) >> slot & 1U) != 0) return below_[child(node, slot)];
    if ((leaf_mask(n) >> slot & 1U) == 0) return {};
    std::uint32_t first = n.triangle_offset;
    for (std::uint32_t s = 0; s < slot; ++s) first += leaf_count(n, s);
    return std::span(bvh_.order).subspan(first, leaf_count(n, slot));
  }

  const BvhFile& bvh_;
  std::vector<std::vector<std::uint32_t>> below_;
};

template <class Coder>
class TreeCode {
 public:
  // `source`: the tree to encode; without it one is decoded. Returns why it cannot be, or nothing.
  TreeCode(Coder& coder, const ZoneMesh& mesh, const NodeRecord& record, bool split, const BvhFile* source)
      : coder_(coder), mesh_(mesh), record_(record), source_(source) {
    out_.split = split;
    if constexpr (Coder::kEncodes) contents_.emplace(*source);
  }

  const char* run() {
    const auto triangles = static_cast<std::uint32_t>(mesh_.triangles.size());
    out_.nodes.reserve(record_.bvh_node_count);
    out_.order.reserve(record_.reference_count);
    waiting_.reserve(record_.reference_count);
    for (std::uint32_t t = triangles; t-- > 0;) waiting_.push_back(triangles - 1 - t);
    out_.nodes.emplace_back();
    pending_.push_back({0, triangles, 1, 0});
    while (!pending_.empty()) {
      const Pending node = pending_.back();
      pending_.pop_back();
      if (const char* fault = visit(node)) return fault;
    }
    return nullptr;
  }

  // Nodes are numbered as a visit allots them: a node's children in turn when it is reached, the first child's subtree
  // first.
  BvhFile take() && { return std::move(out_); }

 private:
  struct Pending {
    std::uint32_t node;
    std::uint32_t count;  // of its triangles, the last ones in waiting_
    std::uint32_t depth;
    std::uint32_t source;  // its number in the tree that is encoded
  };
  static constexpr std::uint32_t kSizes = 3;

  const char* visit(const Pending& at) {
    if (at.depth > record_.bvh_depth) return "the tree is deeper than the index says";
    out_.depth = std::max(out_.depth, at.depth);
    here_.assign(waiting_.end() - at.count, waiting_.end());
    waiting_.resize(waiting_.size() - at.count);
    std::array<std::uint32_t, gpu::kNodeWidth> counts{};
    code_slots(at, counts);

    gpu::PageNode node{};
    std::uint32_t leaf_triangles = 0;
    std::uint32_t references = 0;
    for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
      references += counts[slot];
      if (counts[slot] == 0) continue;
      if (is_node(at, slot, counts[slot])) {
        node.exponents_masks |= 1U << (16 + slot);
      } else {
        node.exponents_masks |= 1U << (24 + slot);
        node.leaf_counts |= counts[slot] << (4 * slot);
        leaf_triangles += counts[slot];
      }
    }
    if (leaf_triangles > gpu::kNodeMaxTriangles) return "a node has too many triangles";
    if (out_.order.size() + waiting_.size() + references > record_.reference_count)
      return "more triangles in leaves than the index says";
    const auto children = static_cast<std::uint32_t>(std::popcount(inner_mask(node)));
    if (out_.nodes.size() + children > record_.bvh_node_count) return "more nodes than the index says";
    if (leaf_triangles > 0) {
      begin_cluster(at);
      node.triangle_offset = static_cast<std::uint32_t>(out_.order.size());
      node.cluster_offset = static_cast<std::uint32_t>(out_.clusters.size()) - 1;
    }
    if (children > 0) node.child_offset = static_cast<std::uint32_t>(out_.nodes.size());
    hand_out(node, counts, references - leaf_triangles);
    push_children(at, node, counts);
    out_.nodes[at.node] = node;
    out_.nodes.resize(out_.nodes.size() + children);
    return nullptr;
  }

  // Fills slots_ with a mask for each triangle here.
  void code_slots(const Pending& at, std::array<std::uint32_t, gpu::kNodeWidth>& counts) {
    slots_.resize(here_.size());
    const std::uint32_t size = here_.size() > 64 ? 2 : here_.size() > 16 ? 1 : 0;
    const Middle middle = middle_of(here_);
    std::uint32_t before = 0;
    for (std::size_t i = 0; i < here_.size(); ++i) {
      std::uint32_t mask = 0;
      if constexpr (Coder::kEncodes) mask = contents_->slots_of(at.source, here_[i]);
      const std::uint32_t octant = octant_of(here_[i], middle);
      std::uint32_t slot = Coder::kEncodes ? static_cast<std::uint32_t>(std::countr_zero(mask)) : 0;
      SlotModel& model = slot_[size][octant][before];
      std::uint32_t same = slot == before ? 1 : 0;
      coder_.bit(model.same, same);
      if (same != 0)
        slot = before;
      else
        model.slot.code(coder_, slot);
      before = slot;
      std::uint32_t done = 1U << slot;
      ++counts[slot];
      while (out_.split && slot + 1 < gpu::kNodeWidth) {
        std::uint32_t more = (mask & ~done) != 0 ? 1 : 0;
        coder_.bit(more_[size], more);
        if (more == 0) break;
        std::uint32_t skip =
            Coder::kEncodes ? static_cast<std::uint32_t>(std::countr_zero(mask & ~done)) - slot - 1 : 0;
        skip_.code(coder_, skip);
        slot = std::min(slot + 1 + skip, gpu::kNodeWidth - 1);
        done |= 1U << slot;
        ++counts[slot];
      }
      slots_[i] = static_cast<std::uint8_t>(done);
    }
  }

  bool is_node(const Pending& at, std::uint32_t slot, std::uint32_t count) {
    if (count > gpu::kLeafMaxTriangles) return true;
    std::uint32_t node = 0;
    if constexpr (Coder::kEncodes) node = inner_mask(source_->nodes[at.source]) >> slot & 1U;
    coder_.bit(node_[count], node);
    return node != 0;
  }

  void begin_cluster(const Pending& at) {
    std::uint32_t fresh = 0;
    if constexpr (Coder::kEncodes) {
      const std::uint32_t cluster = source_->nodes[at.source].cluster_offset;
      fresh = cluster != cluster_ ? 1 : 0;
      cluster_ = cluster;
    }
    if (out_.clusters.empty()) {
      out_.clusters.push_back(0);
      return;
    }
    coder_.bit(fresh_, fresh);
    if (fresh != 0) out_.clusters.push_back(static_cast<std::uint32_t>(out_.order.size()));
  }

  // Leaves' triangles take their places in the page, the others wait, the first child's on top.
  void hand_out(const gpu::PageNode& node, const std::array<std::uint32_t, gpu::kNodeWidth>& counts,
                std::uint32_t below) {
    std::array<std::uint32_t, gpu::kNodeWidth> place{};
    auto position = static_cast<std::uint32_t>(out_.order.size());
    auto wait = static_cast<std::uint32_t>(waiting_.size()) + below;
    for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
      if ((leaf_mask(node) >> slot & 1U) != 0) {
        place[slot] = position;
        position += counts[slot];
      } else {
        wait -= counts[slot];
        place[slot] = wait;
      }
    }
    out_.order.resize(position);
    waiting_.resize(waiting_.size() + below);
    for (std::size_t i = 0; i < here_.size(); ++i)
      for (std::uint32_t mask = slots_[i]; mask != 0; mask &= mask - 1) {
        const auto slot = static_cast<std::uint32_t>(std::countr_zero(mask));
        std::vector<std::uint32_t>& list = (leaf_mask(node) >> slot & 1U) != 0 ? out_.order : waiting_;
        list[place[slot]++] = here_[i];
      }
  }

  void push_children(const Pending& at, const gpu::PageNode& node,
                     const std::array<std::uint32_t, gpu::kNodeWidth>& counts) {
    std::uint32_t child = node.child_offset + static_cast<std::uint32_t>(std::popcount(inner_mask(node)));
    for (std::uint32_t slot = gpu::kNodeWidth; slot-- > 0;) {
      if ((inner_mask(node) >> slot & 1U) == 0) continue;
      Pending below{--child, counts[slot], at.depth + 1, 0};
      if constexpr (Coder::kEncodes) below.source = contents_->child(at.source, slot);
      pending_.push_back(below);
    }
  }

  // Six times the middle of some triangles' box, to compare with twice the sum of a triangle's corners.
  using Middle = std::array<std::uint32_t, 3>;
  [[nodiscard]] Middle middle_of(std::span<const std::uint32_t> triangles) const {
    std::array<std::uint32_t, 3> low = {UINT32_MAX, UINT32_MAX, UINT32_MAX};
    std::array<std::uint32_t, 3> high = {};
    for (const std::uint32_t t : triangles)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::uint32_t sum = sum_of(t, axis);
        low[axis] = std::min(low[axis], sum);
        high[axis] = std::max(high[axis], sum);
      }
    return {low[0] + high[0], low[1] + high[1], low[2] + high[2]};
  }
  [[nodiscard]] std::uint32_t octant_of(std::uint32_t triangle, const Middle& middle) const {
    std::uint32_t octant = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
      octant |= (2 * sum_of(triangle, axis) > middle[axis] ? 1U : 0U) << axis;
    return octant;
  }
  [[nodiscard]] std::uint32_t sum_of(std::uint32_t triangle, std::size_t axis) const {
    const auto& corners = mesh_.triangles[triangle];
    return std::uint32_t{mesh_.vertices[corners[0]][axis]} + mesh_.vertices[corners[1]][axis] +
           mesh_.vertices[corners[2]][axis];
  }

  Coder& coder_;
  const ZoneMesh& mesh_;
  const NodeRecord& record_;
  const BvhFile* source_;
  std::optional<TreeContents> contents_;
  BvhFile out_;
  std::vector<std::uint32_t> waiting_;
  std::vector<Pending> pending_;
  std::vector<std::uint32_t> here_;
  std::vector<std::uint8_t> slots_;
  std::uint32_t cluster_ = 0;
  // By how many triangles there are, the octant of this one and the slot of the one before.
  struct SlotModel {
    Bit same;  // often; then that is all
    Symbol<3> slot;
  };
  std::array<std::array<std::array<SlotModel, gpu::kNodeWidth>, 8>, kSizes> slot_;
  std::array<Bit, kSizes> more_;
  Symbol<3> skip_;
  std::array<Bit, gpu::kLeafMaxTriangles + 1> node_;
  Bit fresh_;
};

}  // namespace zc
