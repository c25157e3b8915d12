// SPDX-License-Identifier: Apache-2.0
// Which nodes should be resident: a pure function of views, index, residency, the previous selection and a budget.
// Threads: pure, but the scratch it works in belongs to one caller · units: metres (CRS), bytes.
//
// Greedy refinement: the root is selected; the node with the largest weighted error whose children all fit in what is
// left of the budget is refined next, and its children are selected together, until the error is within the tolerance
// in every view, later ones too. The weighted error of a node is the largest, over the views, of visible_error_m() /
// distance, later views weighing less, and never more than its parent's. A node that was refined in the previous
// selection counts 1.25 times. Where the eye looks does not count: a mirror shows what is behind it.
//
// A refined node is needed until finer pages cover its ground; then it takes no more of the budget, and only what the
// others leave keeps it resident, first where the camera will soon ask for it again. So the budget goes to what is
// shown, and ground that is new is refined step by step.
//
// How good it is: of all cuts that fit the budget with what they need, none has a smaller largest weighted error than
// the greedy one, as long as no node takes more bytes than its children (to beat it, the node that did not fit would
// have to be refined, and with it all that the greedy order refined before); with a previous selection, none by more
// than the factor 1.25.
//
// Nothing oscillates at a fixed camera: refined nodes only gain, others only lose, and errors fall along every path, so
// the greedy order keeps every refined node ahead of the same rivals, and each rival still finds too little room, until
// something more is covered.
//
// The tree is visited only below what is refined: the world's size does not count.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <span>
#include <vector>

#include "streamer/paging/rendered_cut.h"
#include "streamer/world_format/index_view.h"

namespace zc {

// One camera's view, now or later. Views of several cameras may come in any order.
struct View {
  glm::dvec3 eye = {};            // CRS metres
  std::uint32_t steps_ahead = 0;  // 0: now
};

inline constexpr double kLookAheadDecay = 0.9;  // weight of a view: kLookAheadDecay^steps_ahead
inline constexpr double kRefinedBonus = 1.25;   // the dead band
inline constexpr double kNearestDistance_m = 1.0;

// Pages are placed at multiples of this (32 bytes), so that is what they cost.
inline constexpr std::uint64_t kPageAlignWords = 8;
[[nodiscard]] std::uint64_t pool_bytes(const NodeRecord& node);

// What a node may need at most to be loaded: one that needs more is never selected.
struct LoadLimits {
  std::uint64_t request_bytes = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t scratch_bytes = std::numeric_limits<std::uint64_t>::max();
  bool include_detail = false;  // full detail, too

  [[nodiscard]] bool admit(const NodeRecord& node) const;
};

// For each node that may be selected the selection looks at so many: refined ones beside those that stay.
inline constexpr std::size_t kSelectionNodesPerPage = 2;

struct SelectionQuery {
  std::span<const View> views = {};
  LoadLimits limits = {};
  std::span<const std::uint8_t> previous = {};  // per node: mark_selection()'s of the previous call; empty for none
  const RenderedCut* cut = nullptr;             // what is resident; null: nothing
  std::uint64_t budget_bytes = 0;               // pool bytes, the root's included
  std::size_t most_pages = std::numeric_limits<std::size_t>::max() / kSelectionNodesPerPage;  // selected nodes
  double tolerance = 0.002;
};

struct Selection {
  std::vector<std::uint32_t> by_priority;  // selected nodes, the most needed first, none before its selected ancestors
  std::vector<std::uint32_t> nodes;        // the same, sorted by id
  std::uint64_t bytes = 0;                 // pool bytes of the selected nodes

  std::vector<std::uint32_t> refined;  // whose children are selected, or refined in turn

  // Working memory, kept between calls.
  struct Candidate {
    double error;  // weighted, with the bonus
    double path_weighted;
    double path_plain;
    std::uint32_t node;
  };
  std::vector<Candidate> heap;
  struct Covered {  // a refined node that finer pages cover
    double error;
    std::uint32_t node;
  };
  std::vector<Covered> covered;

  void reserve(std::size_t most_pages);
};

inline constexpr std::uint8_t kMarkSelected = 1;
inline constexpr std::uint8_t kMarkRefined = 2;
// Marks per node, as `previous` takes them: sets those of `selection`, and lists the nodes in `marked`, in place of
// those that were listed there.
void mark_selection(const Selection& selection, std::span<std::uint8_t> marks, std::vector<std::uint32_t>& marked);

// visible_error_m() over distance, the largest over the views.
class ErrorMeter {
 public:
  struct Errors {
    double weighted;  // views with their weights
    double plain;     // all views alike
  };

  // Of the views, or of those that are now.
  ErrorMeter(const IndexView& index, std::span<const View> views, bool now_only = false);
  [[nodiscard]] Errors operator()(const NodeRecord& node) const;
  [[nodiscard]] bool empty() const { return eyes_.empty(); }

 private:
  struct Eye {
    std::array<double, 3> at;  // lattice units from the world's anchor
    double weight_squared;
  };
  std::vector<Eye> eyes_;
  double step_m_;
  double nearest_squared_;  // lattice units
};

// ErrorMeter's, of one node.
[[nodiscard]] double weighted_error(const IndexView& index, std::uint32_t node, std::span<const View> views);

// Replaces `selection`. With no view only the root is selected.
void select_nodes(const IndexView& index, const SelectionQuery& query, Selection& selection);

// What select_nodes takes in memory at most, per node that may be selected, with mark_selection()'s list.
inline constexpr std::uint64_t kSelectionBytesPerPage =
    kSelectionNodesPerPage * (4 * sizeof(std::uint32_t) + sizeof(Selection::Candidate) + sizeof(Selection::Covered));

// The cut that the tolerance asks for now, whatever the budget. What is asked for below a node none of whose children
// is there counts as one node: the world's size does not count.
struct WantedCount {
  std::uint32_t nodes = 0;
  std::uint32_t missing = 0;  // of those: neither resident nor covered by finer pages
};
[[nodiscard]] WantedCount count_wanted(const IndexView& index, std::span<const View> views, double tolerance,
                                       bool include_detail, const RenderedCut& cut);

}  // namespace zc
