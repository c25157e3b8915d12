// SPDX-License-Identifier: Apache-2.0
// Packing boxes and giving them slots: what the fast code promises, against the plain way to say it.
#include "shaders/shared/page_node.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace zc {
namespace {

NodeBox random_box(std::mt19937_64& random, std::uint32_t bits) {
  NodeBox box;
  const std::uint64_t spread = std::uint64_t{1} << bits;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.min[axis] =
        static_cast<std::int32_t>(static_cast<std::int64_t>(random() % spread) - static_cast<std::int64_t>(spread / 2));
    box.max[axis] = box.min[axis] + static_cast<std::int32_t>(random() % (spread / 4 + 1));
  }
  return box;
}

TEST(PackBoxes, HoldsEveryBoxOnTheFinestGridThatReachesAll) {
  std::mt19937_64 random(1);
  for (int round = 0; round < 2000; ++round) {
    std::array<NodeBox, gpu::kNodeWidth> boxes;
    const auto bits = static_cast<std::uint32_t>(random() % 30);
    NodeBox all;
    for (NodeBox& box : boxes) {
      if (random() % 4 == 0) continue;
      box = random_box(random, bits);
      all.add(box);
    }
    if (all.empty()) continue;
    const gpu::PageNode node = pack_boxes(boxes);
    for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
      const WideNodeBox packed = child_box(node, slot);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int64_t step = std::int64_t{1} << node_exponent(node, axis);
        if (boxes[slot].empty()) {
          EXPECT_GT(packed.min[axis], packed.max[axis]);
          continue;
        }
        EXPECT_LE(packed.min[axis], boxes[slot].min[axis]);
        EXPECT_GT(packed.min[axis] + step, boxes[slot].min[axis]);
        EXPECT_GE(packed.max[axis], boxes[slot].max[axis]);
        EXPECT_LT(packed.max[axis] - step, boxes[slot].max[axis]);
        EXPECT_EQ(packed.min[axis] % step, 0);
      }
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::uint32_t e = node_exponent(node, axis);
      if (e == 0) continue;
      const std::int64_t half = std::int64_t{1} << (e - 1);  // one finer would not do
      const std::int64_t low = all.min[axis] >> (e - 1);
      EXPECT_GT(((all.max[axis] + half - 1) >> (e - 1)) - low, 255);
    }
  }
}

// The greedy assignment by its definition: over and over the best pair of all that are left, the first of equals.
std::array<int, gpu::kNodeWidth> plain_slots(std::span<const NodeBox> children) {
  NodeBox all;
  for (const NodeBox& box : children) all.add(box);
  std::array<int, gpu::kNodeWidth> child_of_slot;
  child_of_slot.fill(-1);
  std::vector<bool> placed(children.size());
  for (std::size_t round = 0; round < children.size(); ++round) {
    std::int64_t best = std::numeric_limits<std::int64_t>::min();
    std::size_t best_child = 0;
    std::size_t best_slot = 0;
    for (std::size_t c = 0; c < children.size(); ++c) {
      for (std::size_t slot = 0; slot < gpu::kNodeWidth && !placed[c]; ++slot) {
        std::int64_t towards = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const std::int64_t center =
              std::int64_t{children[c].min[axis]} + children[c].max[axis] - all.min[axis] - all.max[axis];
          towards += (slot >> axis & 1U) != 0 ? center : -center;
        }
        if (child_of_slot[slot] >= 0 || towards <= best) continue;
        best = towards;
        best_child = c;
        best_slot = slot;
      }
    }
    placed[best_child] = true;
    child_of_slot[best_slot] = static_cast<int>(best_child);
  }
  return child_of_slot;
}

TEST(AssignSlots, IsTheGreedyAssignmentByItsDefinition) {
  std::mt19937_64 random(2);
  for (int round = 0; round < 20000; ++round) {
    std::vector<NodeBox> children(random() % (gpu::kNodeWidth + 1));
    // Few bits: many children are equal, or in the middle of an axis.
    const auto bits = static_cast<std::uint32_t>(round % 2 == 0 ? random() % 4 : random() % 30);
    for (NodeBox& box : children) box = random_box(random, bits);
    EXPECT_EQ(assign_slots(children), plain_slots(children)) << round;
  }
}

}  // namespace
}  // namespace zc
