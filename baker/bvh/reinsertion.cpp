// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/bvh/reinsertion.h"

#include <algorithm>

#include "baker/bvh/binned_sah.h"
#include "baker/bvh/packed_box.h"
#include "base/check.h"

namespace zc {
namespace {

constexpr std::int64_t kLargestArea = std::int64_t{3} << 32U;

// Siblings stand together at an odd and the next even place.
std::uint32_t sibling_of(std::uint32_t node) { return ((node - 1) ^ 1U) + 1; }

class Optimizer {
 public:
  explicit Optimizer(const BinaryTree& tree) {
    nodes_.resize(tree.nodes.size());
    for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
      const BinaryNode& node = tree.nodes[i];
      ZC_CHECK(node.is_leaf() || (node.left & 1U) == 1);
      nodes_[i].box = PackedBox(node.box);
      nodes_[i].area = node.box.half_area();
      nodes_[i].left = node.left;
      nodes_[i].reference = node.reference;
      if (!node.is_leaf()) nodes_[node.left].parent = nodes_[node.left + 1].parent = i;
    }
  }

  void pass(float batch) {
    batch_.clear();
    for (std::uint32_t i = 1; i < nodes_.size(); ++i)
      if (may_move(i)) batch_.push_back(static_cast<std::uint64_t>(kLargestArea - nodes_[i].area) << 26U | i);
    const auto limit = static_cast<std::size_t>(static_cast<double>(batch) * static_cast<double>(nodes_.size()));
    const auto size = static_cast<std::ptrdiff_t>(std::min(limit, batch_.size()));
    if (static_cast<std::size_t>(size) < batch_.size()) {
      std::nth_element(batch_.begin(), batch_.begin() + size, batch_.end());
      batch_.erase(batch_.begin() + size, batch_.end());
    }
    std::ranges::sort(batch_);
    for (const std::uint64_t key : batch_) {
      const auto node = static_cast<std::uint32_t>(key & ((1U << 26U) - 1));
      if (!may_move(node)) continue;
      nodes_[node].changed = false;
      const std::uint32_t target = find_place(node);
      if (target != 0) move(node, target);
    }
  }

  // The tree in depth-first order, or nothing when it has become too deep.
  [[nodiscard]] bool emit(const std::vector<BvhReference>& references, BinaryTree& out) const {
    out.nodes.clear();
    out.references.clear();
    out.nodes.reserve(nodes_.size());
    out.references.reserve(references.size());
    out.nodes.emplace_back();
    return emit(0, 0, 1, references, out);
  }

 private:
  struct Node {
    PackedBox box;
    std::int64_t area = 0;
    std::uint32_t left = kNoChild;
    std::uint32_t reference = 0;
    std::uint32_t parent = 0;
    bool changed = true;
    [[nodiscard]] bool is_leaf() const { return left == kNoChild; }
  };

  struct Candidate {
    std::int64_t saved = 0;  // area, with the moving node beside this one
    std::uint32_t node = 0;
  };

  // Nodes whose surroundings are as they were when no better place was found are left alone.
  [[nodiscard]] bool may_move(std::uint32_t node) const {
    const std::uint32_t parent = nodes_[node].parent;
    return parent != 0 && (nodes_[node].changed || nodes_[sibling_of(node)].changed || nodes_[parent].changed);
  }

  struct Search {
    PackedBox box;  // of the node that moves
    std::int64_t area = 0;
    std::int64_t best_saved = 0;
    std::uint32_t best = 0;
    std::uint32_t sibling = 0;
  };

  // Area saved when the node goes beside `at`; `saved` is what it would be were that free.
  std::int64_t weigh(Search& search, std::uint32_t at, std::int64_t saved) const {
    PackedBox joined = nodes_[at].box;
    joined.add(search.box);
    const std::int64_t here = saved - joined.half_area();
    if (here > search.best_saved && at != search.sibling) {
      search.best_saved = here;
      search.best = at;
    }
    return here;
  }

  [[nodiscard]] bool promises(const Search& search, const Candidate& at) const {
    return !nodes_[at.node].is_leaf() && at.saved + nodes_[at.node].area - search.area > search.best_saved;
  }

  // The node beside which it would save most, or 0 when it is best where it is.
  std::uint32_t find_place(std::uint32_t node) {
    const std::uint32_t parent = nodes_[node].parent;
    Search search{nodes_[node].box, nodes_[node].area, 0, 0, sibling_of(node)};
    // Without the node its parent goes; the boxes above shrink to the pivot's.
    std::uint32_t pivot = parent;
    std::uint32_t beside = search.sibling;
    PackedBox pivot_box = nodes_[beside].box;
    std::int64_t saved = nodes_[parent].area;
    for (;;) {
      stack_.assign(1, {weigh(search, beside, saved), beside});
      while (!stack_.empty()) {
        const Candidate top = stack_.back();
        stack_.pop_back();
        if (!promises(search, top)) continue;
        const Node& at = nodes_[top.node];
        const std::int64_t below = top.saved + at.area;
        Candidate nearer = {weigh(search, at.left, below), at.left};
        Candidate farther = {weigh(search, at.left + 1, below), at.left + 1};
        if (farther.saved > nearer.saved) std::swap(nearer, farther);
        if (promises(search, farther)) stack_.push_back(farther);
        if (promises(search, nearer)) stack_.push_back(nearer);
      }
      if (pivot == 0) break;
      if (pivot != parent) {
        pivot_box.add(nodes_[beside].box);
        saved += nodes_[pivot].area - pivot_box.half_area();
      }
      beside = sibling_of(pivot);
      pivot = nodes_[pivot].parent;
    }
    return search.best;
  }

  void adopt(std::uint32_t node) {
    if (nodes_[node].is_leaf()) return;
    nodes_[nodes_[node].left].parent = node;
    nodes_[nodes_[node].left + 1].parent = node;
  }

  // The sibling takes its parent's place; the pair that is free then contains the node and what it goes beside.
  void move(std::uint32_t node, std::uint32_t target) {
    const std::uint32_t sibling = sibling_of(node);
    const std::uint32_t parent = nodes_[node].parent;
    const std::uint32_t above = nodes_[parent].parent;
    Node raised = nodes_[sibling];
    raised.parent = above;
    nodes_[sibling] = nodes_[target];
    nodes_[sibling].parent = target;
    nodes_[node].parent = target;
    nodes_[target].left = std::min(node, sibling);
    nodes_[target].reference = 0;
    nodes_[parent] = raised;
    adopt(parent);
    adopt(sibling);
    nodes_[parent].changed = nodes_[sibling].changed = nodes_[node].changed = nodes_[target].changed = true;
    nodes_[target].box = {};
    refit(target);
    refit(above);
  }

  // Up to where nothing changes.
  void refit(std::uint32_t node) {
    for (;; node = nodes_[node].parent) {
      Node& n = nodes_[node];
      PackedBox box = nodes_[n.left].box;
      box.add(nodes_[n.left + 1].box);
      if (box == n.box) return;
      n.box = box;
      n.area = box.half_area();
      n.changed = true;
      if (node == 0) return;
    }
  }

  bool emit(std::uint32_t from, std::uint32_t to, std::uint32_t depth, const std::vector<BvhReference>& references,
            BinaryTree& out) const {
    if (depth > kBinaryDepthMax) return false;
    const Node& node = nodes_[from];
    out.nodes[to].box = node.box.box();
    if (node.is_leaf()) {
      out.nodes[to].reference = static_cast<std::uint32_t>(out.references.size());
      out.references.push_back(references[node.reference]);
      return true;
    }
    const auto child = static_cast<std::uint32_t>(out.nodes.size());
    out.nodes[to].left = child;
    out.nodes.resize(out.nodes.size() + 2);
    return emit(node.left, child, depth + 1, references, out) &&
           emit(node.left + 1, child + 1, depth + 1, references, out);
  }

  std::vector<Node> nodes_;
  std::vector<std::uint64_t> batch_;  // keys: largest first, then by number
  std::vector<Candidate> stack_;
};

}  // namespace

void optimize_by_reinsertion(BinaryTree& tree, const ReinsertionOptions& options) {
  if (tree.nodes.size() < 5) return;  // nothing can move
  Optimizer optimizer(tree);
  std::vector<BvhReference> references = tree.references;
  BinaryTree next;
  for (std::uint32_t i = 0; i < options.passes; ++i) {
    optimizer.pass(options.batch);
    if (!optimizer.emit(references, next)) return;
    std::swap(tree, next);
  }
}

}  // namespace zc
