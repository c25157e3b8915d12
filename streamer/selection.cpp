// SPDX-License-Identifier: Apache-2.0
#include "streamer/selection.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"

namespace zc {
namespace {

double distance_m(const WorldIndex& index, const NodeRecord& node, const glm::dvec3& eye) {
  const double step = index.step_m();
  double squared = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto anchor = static_cast<double>(index.header.anchor[axis]);  // added as doubles: no overflow
    const double low = (anchor + node.bounds_min[axis]) * step;
    const double high = (anchor + node.bounds_max[axis]) * step;
    const double at = eye[static_cast<glm::dvec3::length_type>(axis)];
    const double away = std::max({low - at, at - high, 0.0});
    squared += away * away;
  }
  return std::sqrt(squared);
}

bool can_refine(const WorldIndex& index, const SelectionQuery& query, std::uint32_t node) {
  const NodeRecord& record = index.nodes[node];
  if (record.child_count == 0) return false;
  for (std::uint32_t c = record.first_child; c < record.first_child + record.child_count; ++c)
    if (query.loadable[c] == 0) return false;
  return true;
}

// Sorts the largest error to the front of a std::*_heap, the lower node first on ties.
bool later(const Selection::Candidate& a, const Selection::Candidate& b) {
  return a.error != b.error ? a.error < b.error : a.node > b.node;
}

// `ancestor_error`: the weighted error never grows on the way down.
void push(const WorldIndex& index, const SelectionQuery& query, std::uint32_t node, double ancestor_error,
          Selection& selection) {
  if (!can_refine(index, query, node)) return;
  const double path_error = std::min(ancestor_error, weighted_error(index, node, query.views));
  // The previous selection is closed under ancestors, so a node has the bonus only where its parent has it too.
  const bool refined = !query.previous.empty() && query.previous[index.nodes[node].first_child] != 0;
  const double error = refined ? path_error * kRefinedBonus : path_error;
  if (!(error > query.tolerance)) return;
  selection.heap.push_back({error, path_error, node});
  std::push_heap(selection.heap.begin(), selection.heap.end(), later);
}

void select_by_budget(const WorldIndex& index, const SelectionQuery& query, Selection& selection) {
  selection.by_priority.assign(1, 0);
  selection.bytes = pool_bytes(index.nodes[0]);
  selection.heap.clear();
  push(index, query, 0, INFINITY, selection);
  while (!selection.heap.empty()) {
    std::pop_heap(selection.heap.begin(), selection.heap.end(), later);
    const Selection::Candidate worst = selection.heap.back();
    selection.heap.pop_back();
    const NodeRecord& record = index.nodes[worst.node];
    std::uint64_t bytes = 0;
    for (std::uint32_t c = record.first_child; c < record.first_child + record.child_count; ++c)
      bytes += pool_bytes(index.nodes[c]);
    if (bytes > query.budget_bytes - selection.bytes) continue;
    selection.bytes += bytes;
    for (std::uint32_t c = record.first_child; c < record.first_child + record.child_count; ++c) {
      selection.by_priority.push_back(c);
      push(index, query, c, worst.path_error, selection);
    }
  }
}

void collect_wanted(const WorldIndex& index, const SelectionQuery& query, Selection& selection) {
  selection.wanted.clear();
  // The heap's memory serves as a stack.
  selection.heap.assign(1, {0, 0, 0});
  while (!selection.heap.empty()) {
    const std::uint32_t node = selection.heap.back().node;
    selection.heap.pop_back();
    const NodeRecord& record = index.nodes[node];
    const bool refinable =
        record.child_count > 0 && (query.include_detail || !index.nodes[record.first_child].is_detail());
    if (!query.views.empty() && refinable && weighted_error(index, node, query.views.first(1)) > query.tolerance) {
      for (std::uint32_t c = record.first_child; c < record.first_child + record.child_count; ++c)
        selection.heap.push_back({0, 0, c});
    } else {
      selection.wanted.push_back(node);
    }
  }
  std::sort(selection.wanted.begin(), selection.wanted.end());
}

}  // namespace

std::uint64_t pool_bytes(const NodeRecord& node) {
  constexpr std::uint64_t kAlign = 4 * kPageAlignWords;
  return (node.page_bytes + kAlign - 1) / kAlign * kAlign;
}

double weighted_error(const WorldIndex& index, std::uint32_t node, std::span<const View> views) {
  const NodeRecord& record = index.nodes[node];
  const double error_m = record.visible_error_m();
  double worst = 0;
  double weight = 1;
  for (const View& view : views) {
    worst = std::max(worst, weight * error_m / std::max(distance_m(index, record, view.eye), kNearestDistance_m));
    weight *= kLookAheadDecay;
  }
  return worst;
}

void select_nodes(const WorldIndex& index, const SelectionQuery& query, Selection& selection) {
  ZC_CHECK(query.loadable.size() == index.nodes.size());
  ZC_CHECK(query.previous.empty() || query.previous.size() == index.nodes.size());
  ZC_CHECK(query.budget_bytes >= pool_bytes(index.nodes[0]));
  select_by_budget(index, query, selection);
  selection.nodes = selection.by_priority;
  std::sort(selection.nodes.begin(), selection.nodes.end());
  collect_wanted(index, query, selection);
}

}  // namespace zc
