// SPDX-License-Identifier: Apache-2.0
// Which nodes should be resident: a pure function of views, index, the previous selection and a budget.
// Threads: pure, but the scratch it works in belongs to one caller · units: metres (CRS), bytes.
//
// Greedy refinement: the root is selected; the node with the largest weighted error whose children all fit in what is
// left of the budget is refined next, and its children are selected together, until the error is within the tolerance.
// The weighted error of a node is the largest, over the views, of visible_error_m() / distance, later views weighing
// less, and never more than its parent's. A node that was refined in the previous selection counts 1.25 times.
//
// Nothing oscillates at a fixed camera: refined nodes only gain, others only lose, and errors fall along every path, so
// the greedy order keeps every refined node ahead of the same rivals, and each rival still finds too little room.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "streamer/world_format/world_index.h"

namespace zc {

struct View {
  glm::dvec3 eye = {};  // CRS metres
};

inline constexpr double kLookAheadDecay = 0.9;  // weight of view i: kLookAheadDecay^i
inline constexpr double kRefinedBonus = 1.25;   // the dead band
inline constexpr double kNearestDistance_m = 1.0;

// Pages are placed at multiples of this (32 bytes), so that is what they cost.
inline constexpr std::uint64_t kPageAlignWords = 8;
[[nodiscard]] std::uint64_t pool_bytes(const NodeRecord& node);

struct SelectionQuery {
  std::span<const View> views = {};             // the current one first
  std::span<const std::uint8_t> loadable = {};  // per node: 0 when it may never be selected (detail, too large to load)
  std::span<const std::uint8_t> previous = {};  // per node: selected by the previous call; empty for none
  std::uint64_t budget_bytes = 0;               // pool bytes, the root's included
  double tolerance = 0.002;
  bool include_detail = false;  // whether `wanted` may ask for full detail
};

struct Selection {
  std::vector<std::uint32_t> by_priority;  // selected nodes, parents first, the most needed first
  std::vector<std::uint32_t> nodes;        // the same, sorted by id
  std::vector<std::uint32_t> wanted;       // cut that the tolerance asks for at views[0], whatever the budget; by id
  std::uint64_t bytes = 0;                 // pool bytes of the selected nodes

  struct Candidate {
    double error;
    double path_error;
    std::uint32_t node;
  };
  std::vector<Candidate> heap;  // working memory, kept between calls
};

// visible_error_m() over distance, the largest over the views with their weights.
[[nodiscard]] double weighted_error(const WorldIndex& index, std::uint32_t node, std::span<const View> views);

// Replaces `selection`. With no view only the root is selected.
void select_nodes(const WorldIndex& index, const SelectionQuery& query, Selection& selection);

// What select_nodes takes in memory at most, per node of the index.
inline constexpr std::uint64_t kSelectionBytesPerNode = 3 * sizeof(std::uint32_t) + sizeof(Selection::Candidate);

}  // namespace zc
