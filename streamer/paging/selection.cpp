// SPDX-License-Identifier: Apache-2.0
#include "streamer/paging/selection.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"
#include "streamer/paging/page_loader.h"

namespace zc {
namespace {

class Selector {
 public:
  Selector(const IndexView& index, const SelectionQuery& query, Selection& selection)
      : nodes_(index.nodes), query_(query), error_of_(index, query.views), out_(selection) {}

  void run() {
    out_.by_priority.assign(1, 0);
    out_.refined.clear();
    out_.covered.clear();
    out_.bytes = pool_bytes(nodes_[0]);
    out_.heap.clear();
    if (!error_of_.empty()) push(0, {INFINITY, INFINITY});
    while (!out_.heap.empty()) {
      std::pop_heap(out_.heap.begin(), out_.heap.end(), later);
      const Selection::Candidate worst = out_.heap.back();
      out_.heap.pop_back();
      refine(worst);
    }
    keep_covered();
  }

 private:
  // Sorts the largest error to the front of a std::*_heap, the lower node first on ties.
  static bool later(const Selection::Candidate& a, const Selection::Candidate& b) {
    return a.error != b.error ? a.error < b.error : a.node > b.node;
  }

  void refine(const Selection::Candidate& worst) {
    const NodeRecord record = nodes_[worst.node];
    std::uint64_t bytes = 0;
    bool admitted = out_.by_priority.size() + record.child_count <= kSelectionNodesPerPage * query_.most_pages;
    for (std::uint32_t c = record.first_child; c < record.first_child + record.child_count; ++c) {
      const NodeRecord child = nodes_[c];
      admitted = admitted && query_.limits.admit(child);
      bytes += pool_bytes(child);
    }
    // The root stays whatever covers it.
    const bool covered = worst.node != 0 && query_.cut != nullptr && query_.cut->refinable(worst.node);
    const std::uint64_t own = covered ? pool_bytes(record) : 0;
    if (pages_ + record.child_count - (covered ? 1 : 0) > query_.most_pages) return;
    if (!admitted || bytes > query_.budget_bytes - (out_.bytes - own)) return;
    out_.bytes += bytes - own;
    pages_ += record.child_count - (covered ? 1 : 0);
    out_.refined.push_back(worst.node);
    if (covered) out_.covered.push_back({worst.path_weighted, worst.node});
    for (std::uint32_t c = record.first_child; c < record.first_child + record.child_count; ++c) {
      out_.by_priority.push_back(c);
      push(c, {worst.path_weighted, worst.path_plain});
    }
  }

  // Of the covered nodes, those that are there or on their way stay, as many as fit, those with the smallest errors
  // first; what stayed before has the dead band.
  void keep_covered() {
    for (Selection::Covered& covered : out_.covered)
      if (marked(covered.node, kMarkSelected)) covered.error /= kRefinedBonus;
    std::sort(out_.covered.begin(), out_.covered.end(),
              [](const auto& a, const auto& b) { return a.error != b.error ? a.error < b.error : a.node < b.node; });
    std::erase_if(out_.covered, [&](const Selection::Covered& covered) {
      const std::uint64_t bytes = pool_bytes(nodes_[covered.node]);
      const bool there = query_.cut->resident(covered.node) || marked(covered.node, kMarkSelected);
      if (!there || bytes > query_.budget_bytes - out_.bytes || pages_ == query_.most_pages) return false;
      out_.bytes += bytes;
      ++pages_;
      return true;
    });
    // What is left is not selected.
    std::sort(out_.covered.begin(), out_.covered.end(), [](const auto& a, const auto& b) { return a.node < b.node; });
    std::erase_if(out_.by_priority, [&](std::uint32_t node) {
      return std::binary_search(out_.covered.begin(), out_.covered.end(), Selection::Covered{0, node},
                                [](const auto& a, const auto& b) { return a.node < b.node; });
    });
  }

  [[nodiscard]] bool marked(std::uint32_t node, std::uint8_t mark) const {
    return !query_.previous.empty() && (query_.previous[node] & mark) != 0;
  }

  // `above`: errors never grow on the way down.
  void push(std::uint32_t node, const ErrorMeter::Errors& above) {
    const NodeRecord record = nodes_[node];
    if (record.child_count == 0) return;
    const ErrorMeter::Errors own = error_of_(record);
    const double weighted = std::min(above.weighted, own.weighted);
    const double plain = std::min(above.plain, own.plain);
    // What was refined is closed under ancestors, so a node has the bonus only where its parent has it too.
    const double bonus = marked(node, kMarkRefined) ? kRefinedBonus : 1.0;
    if (!(plain * bonus > query_.tolerance)) return;
    out_.heap.push_back({weighted * bonus, weighted, plain, node});
    std::push_heap(out_.heap.begin(), out_.heap.end(), later);
  }

  const NodeTable nodes_;
  const SelectionQuery& query_;
  const ErrorMeter error_of_;
  Selection& out_;
  std::size_t pages_ = 1;  // selected so far
};

class WantedCounter {
 public:
  WantedCounter(const IndexView& index, std::span<const View> views, double tolerance, bool include_detail,
                const RenderedCut& cut)
      : nodes_(index.nodes),
        error_of_(index, views, true),
        tolerance_(tolerance),
        include_detail_(include_detail),
        cut_(cut) {}

  WantedCount run() {
    visit(0);
    return count_;
  }

 private:
  void visit(std::uint32_t n) {  // as deep as the tree
    const NodeRecord node = nodes_[n];
    const bool refinable = node.child_count > 0 && (include_detail_ || !nodes_[node.first_child].is_detail());
    if (!refinable || error_of_.empty() || !(error_of_(node).plain > tolerance_)) {
      add(cut_.covered(n));
      return;
    }
    if (!cut_.any_child_covered(n)) {
      add(false);
      return;
    }
    for (std::uint32_t c = node.first_child; c < node.first_child + node.child_count; ++c) visit(c);
  }

  void add(bool there) {
    ++count_.nodes;
    count_.missing += there ? 0 : 1;
  }

  const NodeTable nodes_;
  const ErrorMeter error_of_;
  const double tolerance_;
  const bool include_detail_;
  const RenderedCut& cut_;
  WantedCount count_;
};

}  // namespace

std::uint64_t pool_bytes(const NodeRecord& node) {
  constexpr std::uint64_t kAlign = 4 * kPageAlignWords;
  return (node.page_bytes + kAlign - 1) / kAlign * kAlign;
}

bool LoadLimits::admit(const NodeRecord& node) const {
  return (include_detail || !node.is_detail()) && compressed_bytes(node) + node.page_bytes <= this->request_bytes &&
         zc::scratch_bytes(node) <= this->scratch_bytes;
}

ErrorMeter::ErrorMeter(const IndexView& index, std::span<const View> views, bool now_only) : step_m_(index.step_m()) {
  nearest_squared_ = kNearestDistance_m / step_m_ * (kNearestDistance_m / step_m_);
  eyes_.reserve(views.size());
  for (const View& view : views) {
    if (now_only && view.steps_ahead != 0) continue;
    Eye eye{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      eye.at[axis] = view.eye[static_cast<glm::dvec3::length_type>(axis)] / step_m_ -
                     static_cast<double>(index.header.anchor[axis]);
    double weight = 1;
    for (std::uint32_t i = 0; i < view.steps_ahead; ++i) weight *= kLookAheadDecay;
    eye.weight_squared = weight * weight;
    eyes_.push_back(eye);
  }
}

ErrorMeter::Errors ErrorMeter::operator()(const NodeRecord& node) const {
  double most = 0;                                           // weight² over distance²
  double nearest = std::numeric_limits<double>::infinity();  // distance²
  for (const Eye& eye : eyes_) {
    double squared = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double away =
          std::max(std::max(node.bounds_min[axis] - eye.at[axis], eye.at[axis] - node.bounds_max[axis]), 0.0);
      squared += away * away;
    }
    squared = std::max(squared, nearest_squared_);
    nearest = std::min(nearest, squared);
    most = std::max(most, eye.weight_squared / squared);
  }
  const double error = static_cast<double>(node.visible_error_m()) / step_m_;  // in lattice units, as the distances
  return {error * std::sqrt(most), error / std::sqrt(nearest)};
}

double weighted_error(const IndexView& index, std::uint32_t node, std::span<const View> views) {
  return ErrorMeter(index, views)(index.nodes[node]).weighted;
}

void select_nodes(const IndexView& index, const SelectionQuery& query, Selection& selection) {
  ZC_CHECK(query.previous.empty() || query.previous.size() == index.nodes.size());
  ZC_CHECK(query.budget_bytes >= pool_bytes(index.nodes[0]));
  Selector(index, query, selection).run();
  selection.nodes = selection.by_priority;
  std::sort(selection.nodes.begin(), selection.nodes.end());
}

void Selection::reserve(std::size_t most_pages) {
  const std::size_t most = kSelectionNodesPerPage * most_pages;
  for (std::vector<std::uint32_t>* list : {&by_priority, &nodes, &refined}) list->reserve(most);
  heap.reserve(most);
  covered.reserve(most);
}

void mark_selection(const Selection& selection, std::span<std::uint8_t> marks, std::vector<std::uint32_t>& marked) {
  for (const std::uint32_t node : marked) marks[node] = 0;
  marked = selection.nodes;
  for (const std::uint32_t node : selection.nodes) marks[node] = kMarkSelected;
  for (const std::uint32_t node : selection.refined) {
    if (marks[node] == 0) marked.push_back(node);
    marks[node] |= kMarkRefined;
  }
}

WantedCount count_wanted(const IndexView& index, std::span<const View> views, double tolerance, bool include_detail,
                         const RenderedCut& cut) {
  return WantedCounter(index, views, tolerance, include_detail, cut).run();
}

}  // namespace zc
