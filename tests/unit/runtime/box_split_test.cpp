// SPDX-License-Identifier: Apache-2.0
#include "runtime/scene/box_split.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

namespace zc {
namespace {

std::vector<NodeBox> random_boxes(std::size_t count, std::uint32_t spread, std::mt19937& random) {
  std::vector<NodeBox> boxes(count);
  for (NodeBox& box : boxes) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.min[axis] = static_cast<std::int32_t>(random() % spread);
      box.max[axis] = box.min[axis] + static_cast<std::int32_t>(random() % (spread / 8 + 1));
    }
  }
  return boxes;
}

double cost(const std::vector<NodeBox>& boxes, std::span<const std::uint32_t> numbers) {
  NodeBox all;
  for (const std::uint32_t i : numbers) all.add(boxes[i]);
  return all.half_area() * static_cast<double>(numbers.size());
}

double split_cost(const std::vector<NodeBox>& boxes, std::span<const std::uint32_t> numbers, std::size_t first) {
  return cost(boxes, numbers.first(first)) + cost(boxes, numbers.subspan(first));
}

// The least over all places in the orders along all axes.
double least_cost(const std::vector<NodeBox>& boxes, std::vector<std::uint32_t> numbers) {
  double least = INFINITY;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::ranges::stable_sort(numbers, {},
                             [&](std::uint32_t i) { return std::int64_t{boxes[i].min[axis]} + boxes[i].max[axis]; });
    for (std::size_t first = 1; first < numbers.size(); ++first)
      least = std::min(least, split_cost(boxes, numbers, first));
  }
  return least;
}

std::vector<std::uint32_t> every_second(std::size_t count) {
  std::vector<std::uint32_t> numbers(count);
  for (std::size_t i = 0; i < count; ++i) numbers[i] = static_cast<std::uint32_t>(2 * i);
  return numbers;
}

void expect_halves(const std::vector<NodeBox>& boxes, std::span<const std::uint32_t> before,
                   std::span<const std::uint32_t> after, const BoxSplit::Halves& halves) {
  ASSERT_GT(halves.first, 0U);
  ASSERT_LT(halves.first, after.size());
  EXPECT_TRUE(std::ranges::is_sorted(after.first(halves.first)));
  EXPECT_TRUE(std::ranges::is_sorted(after.subspan(halves.first)));
  std::vector<std::uint32_t> sorted(after.begin(), after.end());
  std::ranges::sort(sorted);
  EXPECT_TRUE(std::ranges::equal(sorted, before));
  for (std::size_t i = 0; i < after.size(); ++i) {
    const FloatBox& half = i < halves.first ? halves.left : halves.right;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_LE(half.low[axis], static_cast<float>(boxes[after[i]].min[axis]));
      EXPECT_GE(half.high[axis], static_cast<float>(boxes[after[i]].max[axis]));
    }
  }
}

TEST(BoxSplit, FindsTheBestPlaceAmongFewAndANearOneAmongMany) {
  std::mt19937 random(3);
  for (const std::size_t count : {2U, 3U, 5U, 12U, 13U, 40U, 300U}) {
    for (int round = 0; round < 50; ++round) {
      const auto boxes = random_boxes(2 * count, round % 5 == 0 ? 4 : 100000, random);
      BoxSplit split;
      split.begin(boxes);
      const std::vector<std::uint32_t> before = every_second(count);
      std::vector<std::uint32_t> numbers = before;
      const BoxSplit::Halves halves = split.by_area(numbers);
      expect_halves(boxes, before, numbers, halves);
      EXPECT_LE(split_cost(boxes, numbers, halves.first), least_cost(boxes, before) * (count <= 12 ? 1.0001 : 1.25))
          << count;
    }
  }
}

TEST(BoxSplit, ByCountHalvesAlsoWhatCoincides) {
  std::mt19937 random(4);
  for (const std::uint32_t spread : {1U, 3U, 1000U}) {
    for (const std::size_t count : {2U, 3U, 100U}) {
      const auto boxes = random_boxes(2 * count, spread, random);
      BoxSplit split;
      split.begin(boxes);
      for (const bool by_count : {true, false}) {
        std::vector<std::uint32_t> numbers = every_second(count);
        const BoxSplit::Halves halves = by_count ? split.by_count(numbers) : split.by_area(numbers);
        expect_halves(boxes, every_second(count), numbers, halves);
        if (by_count) {
          EXPECT_EQ(halves.first, count / 2);
        }
      }
    }
  }
}

}  // namespace
}  // namespace zc
