// SPDX-License-Identifier: Apache-2.0
// select_nodes against an exact solver: every cut that fits the budget with what it needs, on small random trees: with
// all above it where nothing is covered yet, with the root alone where everything is. What is compared is computed here
// from the records, not by the selection's own code.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <random>

#include "streamer/paging/selection.h"

namespace zc {
namespace {

constexpr double kSide_m = 1024;

std::uint32_t below(std::uint32_t end, std::mt19937& random) { return static_cast<std::uint32_t>(random() % end); }

// A tree of at most `inner` refinable nodes, two to four children each, that need not share their parent's ground
// evenly; pages and errors at random, errors mostly but not always falling.
WorldIndex random_tree(std::uint32_t inner, std::mt19937& random) {
  WorldIndex index;
  const auto share = [&] { return static_cast<double>(random() % 1000) / 1000; };
  const auto add = [&](std::int32_t parent, std::uint32_t depth, double x, double y, double side, float error) {
    NodeRecord node;
    node.parent = parent;
    node.depth = depth;
    node.bounds_min = {static_cast<std::int32_t>(x * 256), static_cast<std::int32_t>(y * 256), 0};
    node.bounds_max = {static_cast<std::int32_t>((x + side) * 256), static_cast<std::int32_t>((y + side) * 256), 2560};
    node.error_max_m = error;
    node.page_bytes = static_cast<std::uint32_t>(32 * (5 + random() % 60));
    index.nodes.push_back(node);
  };
  add(-1, 0, 0, 0, kSide_m, 20);
  for (std::uint32_t n = 0; n < index.nodes.size() && inner > 0; ++n) {
    if (n > 0 && random() % 3 == 0) continue;
    --inner;
    const NodeRecord parent = index.nodes[n];
    const double side = (parent.bounds_max[0] - parent.bounds_min[0]) / 256.0 / 2;
    index.nodes[n].first_child = static_cast<std::uint32_t>(index.nodes.size());
    index.nodes[n].child_count = 2 + below(3, random);
    for (std::uint32_t c = 0; c < index.nodes[n].child_count; ++c)
      add(static_cast<std::int32_t>(n), parent.depth + 1, parent.bounds_min[0] / 256.0 + side * (c % 2),
          parent.bounds_min[1] / 256.0 + side * (c / 2), side,
          static_cast<float>(parent.error_max_m * (0.2 + 0.9 * share())));
  }
  // No node takes more than its children do.
  for (NodeRecord& node : index.nodes) {
    std::uint32_t bytes = 0;
    for (std::uint32_t c = node.first_child; c < node.first_child + node.child_count; ++c)
      bytes += index.nodes[c].page_bytes;
    if (bytes > 0) node.page_bytes = std::min(node.page_bytes, bytes);
  }
  return index;
}

// Of a node: the largest over the views of error over distance, and never more than above it.
std::vector<double> weighted_errors(const WorldIndex& index, const std::vector<View>& views) {
  std::vector<double> errors;
  for (const NodeRecord& node : index.nodes) {
    double worst = 0;
    for (const View& view : views) {
      double squared = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double at = view.eye[static_cast<int>(axis)] * 256;
        const double near = std::clamp<double>(at, node.bounds_min[axis], node.bounds_max[axis]);
        squared += (at - near) * (at - near);
      }
      worst = std::max(worst, std::pow(kLookAheadDecay, view.steps_ahead) * node.error_max_m /
                                  std::max(std::sqrt(squared) / 256, kNearestDistance_m));
    }
    errors.push_back(node.parent < 0 ? worst : std::min(worst, errors[static_cast<std::size_t>(node.parent)]));
  }
  return errors;
}

struct Quality {
  double largest = 0;  // weighted error of the cut
  double mean = 0;     // over the ground
};

Quality quality_of(const WorldIndex& index, const std::vector<double>& errors, const std::vector<bool>& refined) {
  Quality quality;
  const std::function<void(std::uint32_t)> visit = [&](std::uint32_t n) {
    const NodeRecord& node = index.nodes[n];
    if (refined[n]) {
      for (std::uint32_t c = node.first_child; c < node.first_child + node.child_count; ++c) visit(c);
      return;
    }
    const double side = (node.bounds_max[0] - node.bounds_min[0]) / 256.0 / kSide_m;
    quality.largest = std::max(quality.largest, errors[n]);
    quality.mean += errors[n] * side * side;
  };
  visit(0);
  return quality;
}

// Calls `found` with every set of refined nodes whose cut fits; `covered`: refined nodes take no room, but the root.
void each_set(const WorldIndex& index, std::uint64_t budget, bool covered,
              const std::function<void(const std::vector<bool>&)>& found) {
  std::vector<bool> refined(index.nodes.size());
  // Nodes in the order of the index: a node may be refined when its parent is.
  const std::function<void(std::uint32_t, std::uint64_t)> choose = [&](std::uint32_t n, std::uint64_t left) {
    if (n == index.nodes.size()) return found(refined);
    const NodeRecord& node = index.nodes[n];
    choose(n + 1, left);
    if (node.child_count == 0 || (n > 0 && !refined[static_cast<std::size_t>(node.parent)])) return;
    std::uint64_t bytes = 0;
    for (std::uint32_t c = node.first_child; c < node.first_child + node.child_count; ++c)
      bytes += pool_bytes(index.nodes[c]);
    if (covered && n > 0) bytes -= pool_bytes(node);
    if (bytes > left) return;
    refined[n] = true;
    choose(n + 1, left - bytes);
    refined[n] = false;
  };
  choose(0, budget - pool_bytes(index.nodes[0]));
}

std::vector<bool> refined_by(const WorldIndex& index, const Selection& selection) {
  std::vector<bool> refined(index.nodes.size());
  for (const std::uint32_t n : selection.refined) refined[n] = true;
  return refined;
}

// All that is selected, and nothing more than fits; every cut node is there, and every refined one that is not covered.
void check_selected(const WorldIndex& index, const Selection& selection, std::uint64_t budget, bool covered) {
  const std::vector<bool> refined = refined_by(index, selection);
  std::uint64_t bytes = 0;
  for (const std::uint32_t n : selection.nodes) bytes += pool_bytes(index.nodes[n]);
  EXPECT_EQ(bytes, selection.bytes);
  EXPECT_LE(bytes, budget);
  for (std::uint32_t n = 0; n < index.nodes.size(); ++n) {
    const bool reached = n == 0 || refined[static_cast<std::size_t>(index.nodes[n].parent)];
    const bool selected = std::binary_search(selection.nodes.begin(), selection.nodes.end(), n);
    if (!reached) {
      EXPECT_FALSE(selected || refined[n]);
    } else if (n == 0 || !refined[n] || !covered) {
      EXPECT_TRUE(selected);
    }
  }
}

RenderedCut everything(const WorldIndex& index) {
  RenderedCut cut(index);
  for (std::uint32_t n = 0; n < index.nodes.size(); ++n) cut.add(n);
  return cut;
}

std::vector<View> random_views(std::mt19937& random) {
  std::vector<View> views;
  const double x = below(1024, random);
  const double y = below(1024, random);
  for (std::uint32_t i = 0; i <= random() % 4; ++i) views.push_back({{x + 40.0 * i, y, 2}, i});
  if (random() % 3 == 0) views.push_back({{below(1024, random), below(1024, random), 2}, 0});  // another camera
  return views;
}

struct Case {
  WorldIndex index;
  std::uint64_t budget = 0;
};

Case random_case(std::mt19937& random) {
  Case out{random_tree(3 + below(14, random), random), 0};
  std::uint64_t all = 0;
  for (const NodeRecord& node : out.index.nodes) all += pool_bytes(node);
  const std::uint64_t least = pool_bytes(out.index.nodes[0]);
  out.budget = least + random() % (all - least + 64);
  return out;
}

TEST(SelectionOptimality, no_cut_within_the_budget_has_a_smaller_largest_error) {
  for (const bool covered : {false, true}) {
    std::mt19937 random(11);
    double ratios = 0;
    double worst = 0;
    int cases = 0;
    for (int i = 0; i < 400; ++i) {
      const auto [index, budget] = random_case(random);
      const std::vector<View> views = random_views(random);
      const RenderedCut cut = everything(index);
      Selection selection;
      select_nodes(index, {.views = views, .cut = covered ? &cut : nullptr, .budget_bytes = budget, .tolerance = 1e-12},
                   selection);
      check_selected(index, selection, budget, covered);

      const std::vector<double> errors = weighted_errors(index, views);
      const Quality ours = quality_of(index, errors, refined_by(index, selection));
      Quality best{INFINITY, INFINITY};
      each_set(index, budget, covered, [&, &index = index](const std::vector<bool>& refined) {
        const Quality other = quality_of(index, errors, refined);
        best = {std::min(best.largest, other.largest), std::min(best.mean, other.mean)};
      });
      EXPECT_NEAR(ours.largest, best.largest, 1e-9 * best.largest) << i;
      ratios += ours.mean / best.mean;
      worst = std::max(worst, ours.mean / best.mean);
      ++cases;
    }
    // The mean over the ground is not what is minimised; it suffers little.
    if (std::getenv("ZONECAST_PRINT") != nullptr)
      std::printf("mean error over the ground: %.3f of the least, %.3f at worst\n", ratios / cases, worst);
    EXPECT_LT(ratios / cases, 1.02);
  }
}

TEST(SelectionOptimality, with_a_past_no_cut_beats_it_by_more_than_the_dead_band) {
  for (const bool covered : {false, true}) {
    std::mt19937 random(12);
    for (int i = 0; i < 400; ++i) {
      const auto [index, budget] = random_case(random);
      const RenderedCut cut = everything(index);
      std::vector<std::uint8_t> previous(index.nodes.size());
      std::vector<std::uint32_t> marked;
      Selection selection;
      std::vector<View> views;
      for (int step = 0; step < 4; ++step) {
        views = random_views(random);
        select_nodes(index,
                     {.views = views,
                      .previous = previous,
                      .cut = covered ? &cut : nullptr,
                      .budget_bytes = budget,
                      .tolerance = 1e-12},
                     selection);
        check_selected(index, selection, budget, covered);
        mark_selection(selection, previous, marked);
      }
      const std::vector<double> errors = weighted_errors(index, views);
      double best = INFINITY;
      each_set(index, budget, covered, [&, &index = index](const std::vector<bool>& refined) {
        best = std::min(best, quality_of(index, errors, refined).largest);
      });
      EXPECT_LE(quality_of(index, errors, refined_by(index, selection)).largest, kRefinedBonus * best * (1 + 1e-9))
          << i;
    }
  }
}

}  // namespace
}  // namespace zc
