// SPDX-License-Identifier: Apache-2.0
#include "streamer/paging/selection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "streamer/paging/rendered_cut.h"

namespace zc {
namespace {

// A full quadtree without files: `levels` deep over 1024 m, pages of random size, errors halving with jitter.
WorldIndex make_index(std::uint32_t levels, std::uint32_t seed) {
  WorldIndex index;
  std::mt19937 random(seed);
  const auto add = [&](std::int32_t parent, std::uint32_t depth, std::uint32_t x, std::uint32_t y) {
    NodeRecord node;
    node.parent = parent;
    node.depth = depth;
    node.cell_x = x;
    node.cell_y = y;
    const auto size = static_cast<std::int32_t>((1024U << 8U) >> depth);
    node.bounds_min = {static_cast<std::int32_t>(x) * size, static_cast<std::int32_t>(y) * size, 0};
    node.bounds_max = {node.bounds_min[0] + size, node.bounds_min[1] + size, 50 << 8U};
    node.error_max_m = 16.0F / static_cast<float>(1U << depth) * (0.5F + static_cast<float>(random() % 1000) / 500.0F);
    node.page_bytes = 4 * (100 + static_cast<std::uint32_t>(random() % 400));
    index.nodes.push_back(node);
  };
  add(-1, 0, 0, 0);
  for (std::uint32_t n = 0; n < index.nodes.size(); ++n) {
    const NodeRecord parent = index.nodes[n];
    if (parent.depth + 1 == levels) continue;
    index.nodes[n].first_child = static_cast<std::uint32_t>(index.nodes.size());
    index.nodes[n].child_count = 4;
    for (std::uint32_t c = 0; c < 4; ++c)
      add(static_cast<std::int32_t>(n), parent.depth + 1, 2 * parent.cell_x + c % 2, 2 * parent.cell_y + c / 2);
  }
  return index;
}

struct Chooser {
  explicit Chooser(const WorldIndex& world) : index(world), previous(world.nodes.size()) {}

  const Selection& run(std::span<const View> views, std::uint64_t budget) {
    select_nodes(index, {.views = views, .previous = previous, .cut = cut, .budget_bytes = budget}, selection);
    mark_selection(selection, previous, marked);
    return selection;
  }

  const WorldIndex& index;
  const RenderedCut* cut = nullptr;
  std::vector<std::uint8_t> previous;
  std::vector<std::uint32_t> marked;
  Selection selection;
};

TEST(Selection, fits_its_budget_and_is_closed_under_ancestors_and_siblings) {
  const WorldIndex index = make_index(5, 1);
  Chooser chooser(index);
  std::mt19937 random(2);
  for (int i = 0; i < 200; ++i) {
    const View view{{random() % 1024, random() % 1024, 2}};
    const std::uint64_t budget = 2048 + random() % 200000;
    const Selection& selection = chooser.run(std::span(&view, 1), budget);
    EXPECT_LE(selection.bytes, budget);
    EXPECT_TRUE(std::is_sorted(selection.nodes.begin(), selection.nodes.end()));
    std::vector<bool> seen(index.nodes.size());
    std::uint64_t bytes = 0;
    for (const std::uint32_t n : selection.by_priority) {
      seen[n] = true;
      bytes += pool_bytes(index.nodes[n]);
      if (n == 0) continue;
      EXPECT_TRUE(seen[static_cast<std::size_t>(index.nodes[n].parent)]);  // parents come first
    }
    EXPECT_EQ(bytes, selection.bytes);
    for (const std::uint32_t n : selection.nodes) {
      if (n == 0) continue;
      const NodeRecord& parent = index.nodes[static_cast<std::size_t>(index.nodes[n].parent)];
      for (std::uint32_t c = parent.first_child; c < parent.first_child + parent.child_count; ++c) EXPECT_TRUE(seen[c]);
    }
  }
}

TEST(Selection, at_a_fixed_camera_never_changes_again) {
  std::mt19937 random(4);
  for (std::uint32_t seed = 0; seed < 40; ++seed) {
    const WorldIndex index = make_index(5, seed);
    Chooser chooser(index);
    // Arrive with some history.
    for (int i = 0; i < 5; ++i) {
      const View view{{random() % 1024, random() % 1024, 2}};
      chooser.run(std::span(&view, 1), 40000);
    }
    const std::vector<View> views = {View{{random() % 1024, random() % 1024, 2}}, View{{random() % 1024, 500, 2}, 1}};
    const std::uint64_t budget = 3000 + random() % 100000;
    const std::vector<std::uint32_t> first = chooser.run(views, budget).nodes;
    for (int i = 0; i < 20; ++i) EXPECT_EQ(chooser.run(views, budget).nodes, first);
  }
}

TEST(Selection, a_small_step_back_and_forth_does_not_swap_nodes) {
  const WorldIndex index = make_index(5, 9);
  Chooser chooser(index);
  const View here{{500, 500, 2}};
  const View there{{500.5, 500, 2}};
  chooser.run(std::span(&here, 1), 40000);
  const std::vector<std::uint32_t> second = chooser.run(std::span(&there, 1), 40000).nodes;
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(chooser.run(std::span(&here, 1), 40000).nodes, second);
    EXPECT_EQ(chooser.run(std::span(&there, 1), 40000).nodes, second);
  }
}

TEST(Selection, with_budget_enough_holds_every_wanted_node) {
  const WorldIndex index = make_index(5, 5);
  Chooser chooser(index);
  const View view{{300, 300, 2}};
  RenderedCut cut(index);
  for (const std::uint32_t n : chooser.run(std::span(&view, 1), 1ULL << 40U).nodes) cut.add(n);
  const WantedCount wanted = count_wanted(index, std::span(&view, 1), 0.002, false, cut);
  EXPECT_GT(wanted.nodes, 4U);
  EXPECT_EQ(wanted.missing, 0U);
}

TEST(Selection, detail_is_selected_and_wanted_only_when_asked_for) {
  WorldIndex index = make_index(1, 1);
  index.nodes.push_back(index.nodes[0]);
  index.nodes[1].parent = 0;
  index.nodes[1].flags = kNodeDetail;
  index.nodes[0].first_child = 1;
  index.nodes[0].child_count = 1;
  const View view{{500, 500, 2}};
  RenderedCut zone(index);
  zone.add(0);
  RenderedCut both(index);
  both.add(0);
  both.add(1);
  Selection selection;
  select_nodes(index, {.views = std::span(&view, 1), .budget_bytes = 1 << 20U}, selection);
  EXPECT_EQ(selection.nodes, (std::vector<std::uint32_t>{0}));
  EXPECT_EQ(count_wanted(index, std::span(&view, 1), 0.002, false, zone).missing, 0U);
  select_nodes(index, {.views = std::span(&view, 1), .limits = {.include_detail = true}, .budget_bytes = 1 << 20U},
               selection);
  EXPECT_EQ(selection.nodes, (std::vector<std::uint32_t>{0, 1}));
  EXPECT_EQ(count_wanted(index, std::span(&view, 1), 0.002, true, zone).missing, 1U);
  EXPECT_EQ(count_wanted(index, std::span(&view, 1), 0.002, true, both).missing, 0U);
}

std::vector<std::uint32_t> collected(const RenderedCut& cut) {
  std::vector<std::uint32_t> shown;
  cut.collect(shown);
  return shown;
}

TEST(RenderedCut, covers_every_leaf_exactly_once_with_the_deepest_resident_nodes_after_any_changes) {
  const WorldIndex index = make_index(5, 1);
  std::mt19937 random(6);
  RenderedCut cut(index);
  cut.add(0);
  for (int i = 0; i < 300; ++i) {
    const std::uint32_t share = static_cast<std::uint32_t>(random() % 10);
    for (std::uint32_t n = 1; n < index.nodes.size(); ++n) {
      const bool there = random() % 10 < share;
      if (there == cut.resident(n)) continue;
      if (there)
        cut.add(n);
      else
        cut.remove(n);
    }
    const std::vector<std::uint32_t> shown = collected(cut);
    std::vector<bool> covered(index.nodes.size());
    for (std::uint32_t n = static_cast<std::uint32_t>(index.nodes.size()); n-- > 0;) {
      const NodeRecord& node = index.nodes[n];
      bool below = node.child_count > 0;
      for (std::uint32_t c = node.first_child; c < node.first_child + node.child_count; ++c)
        below = below && covered[c];
      covered[n] = below || cut.resident(n);
      if (below) {
        EXPECT_FALSE(std::binary_search(shown.begin(), shown.end(), n));
      }
    }
    for (const std::uint32_t n : shown) EXPECT_TRUE(cut.resident(n));
    for (std::uint32_t n = 0; n < index.nodes.size(); ++n) {
      if (index.nodes[n].child_count > 0) continue;
      int times = 0;
      for (std::int32_t a = static_cast<std::int32_t>(n); a >= 0; a = index.nodes[static_cast<std::size_t>(a)].parent)
        times += std::binary_search(shown.begin(), shown.end(), static_cast<std::uint32_t>(a)) ? 1 : 0;
      ASSERT_EQ(times, 1);
    }
  }
}

TEST(RenderedCut, a_broken_inner_node_does_not_hide_what_is_below_it) {
  const WorldIndex index = make_index(3, 1);
  RenderedCut cut(index);
  for (std::uint32_t n = 0; n < index.nodes.size(); ++n)
    if (n != 1) cut.add(n);
  EXPECT_EQ(collected(cut).size(), 16U);
  cut.remove(index.nodes[1].first_child);
  EXPECT_EQ(collected(cut), (std::vector<std::uint32_t>{0}));
}

}  // namespace
}  // namespace zc
