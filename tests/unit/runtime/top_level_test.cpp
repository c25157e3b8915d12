// SPDX-License-Identifier: Apache-2.0
#include "runtime/top_level.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <set>
#include <vector>

#include "shaders/shared/page.h"

namespace zc {
namespace {

struct Walk {
  const TopLevel& top;
  const std::vector<ZoneBounds>& zones;
  std::multiset<std::uint32_t> found;
  std::uint32_t depth = 0;

  // Visits a child and returns the bounds of what lies under it, which its parent's box must be.
  void child(std::uint32_t ref, const ZoneBounds& box, std::uint32_t level) {
    if (ref == gpu::kRefNone) return;
    if ((ref & gpu::kRefLeaf) != 0) {
      const std::uint32_t slot = ref & ~gpu::kRefLeaf;
      ASSERT_LT(slot, zones.size());
      found.insert(slot);
      EXPECT_EQ(box.min, zones[slot].min);
      EXPECT_EQ(box.max, zones[slot].max);
      return;
    }
    ASSERT_LT(ref, top.nodes.size());
    const ZoneBounds a = box_of(top.nodes[ref], 0);
    const ZoneBounds b = box_of(top.nodes[ref], 1);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(box.min[i], std::min(a.min[i], b.min[i]));
      EXPECT_EQ(box.max[i], std::max(a.max[i], b.max[i]));
    }
    node(ref, level + 1);
  }
  void node(std::uint32_t index, std::uint32_t level) {
    depth = std::max(depth, level);
    child(top.nodes[index].ref0, box_of(top.nodes[index], 0), level);
    child(top.nodes[index].ref1, box_of(top.nodes[index], 1), level);
  }
  static ZoneBounds box_of(const gpu::TopNode& n, int which) {
    if (which == 0) return {{n.min0_x, n.min0_y, n.min0_z}, {n.max0_x, n.max0_y, n.max0_z}};
    return {{n.min1_x, n.min1_y, n.min1_z}, {n.max1_x, n.max1_y, n.max1_z}};
  }
};

std::vector<ZoneBounds> scattered(std::size_t count) {
  std::vector<ZoneBounds> zones;
  std::uint32_t state = 12345;
  const auto next = [&](std::uint32_t below) {
    state = state * 1664525U + 1013904223U;
    return static_cast<std::int32_t>((state >> 8U) % below);
  };
  for (std::size_t i = 0; i < count; ++i) {
    const std::array<std::int32_t, 3> low = {next(2000000) - 1000000, next(2000000) - 1000000, next(20000)};
    zones.push_back({low, {low[0] + next(60000), low[1] + next(60000), low[2] + next(20000)}});
  }
  return zones;
}

void expect_sound(const std::vector<ZoneBounds>& zones) {
  const TopLevel top = build_top_level(zones);
  Walk walk{top, zones, {}, 0};
  walk.node(0, 1);
  EXPECT_EQ(walk.found.size(), zones.size());
  for (std::uint32_t i = 0; i < zones.size(); ++i) EXPECT_EQ(walk.found.count(i), 1U) << "zone " << i;
  EXPECT_EQ(walk.depth, top.depth);
  EXPECT_LE(top.nodes.size(), std::max<std::size_t>(1, zones.size()));
}

TEST(TopLevel, HoldsEveryZoneOnceInTightBoxes) {
  for (const std::size_t count : {0U, 1U, 2U, 3U, 17U, 500U}) expect_sound(scattered(count));
}

TEST(TopLevel, StaysShallowWhenAllZonesCoincide) {
  const std::vector<ZoneBounds> zones(1000, ZoneBounds{{0, 0, 0}, {10, 10, 10}});
  expect_sound(zones);
  EXPECT_LE(build_top_level(zones).depth, 24U + 10U);
}

}  // namespace
}  // namespace zc
