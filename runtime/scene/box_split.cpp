// SPDX-License-Identifier: Apache-2.0
#include "runtime/scene/box_split.h"

#include <algorithm>
#include <limits>

namespace zc {
namespace {

constexpr std::uint32_t kBins = 8;
constexpr float kFlat = 0.25F;          // of the widest spread: along a flatter axis of many boxes nobody looks
constexpr std::size_t kSweepMost = 12;  // a sweep sorts by insertion

}  // namespace

NodeBox to_node_box(const FloatBox& box) {
  constexpr float kMost = 2147483520.0F;  // the last one that an integer takes
  NodeBox out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out.min[axis] = static_cast<std::int32_t>(std::min(box.low[axis], kMost));
    out.max[axis] = static_cast<std::int32_t>(std::min(box.high[axis], kMost));
  }
  return out;
}

FloatBox BoxSplit::bounds(std::span<const std::uint32_t> numbers) const {
  FloatBox all = FloatBox::none();
  for (const std::uint32_t i : numbers) all.add(boxes_[i]);
  return all;
}

void BoxSplit::reserve(std::size_t boxes) {
  boxes_.reserve(boxes);
  centers_.reserve(boxes);
  bins_.reserve(boxes);
  marks_.reserve(boxes);
  kept_.reserve(boxes);
  keys_.reserve(boxes);
}

void BoxSplit::begin(std::span<const NodeBox> boxes) {
  boxes_.resize(boxes.size());
  centers_.resize(boxes.size());
  bins_.resize(boxes.size());
  marks_.resize(boxes.size());
  kept_.resize(boxes.size());
  keys_.resize(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const NodeBox& box = boxes[i];
    const Lanes low = {static_cast<float>(box.min[0]), static_cast<float>(box.min[1]), static_cast<float>(box.min[2]),
                       0};
    const Lanes high = {static_cast<float>(box.max[0]), static_cast<float>(box.max[1]), static_cast<float>(box.max[2]),
                        0};
    boxes_[i] = {low, high};
    centers_[i] = low + high;
  }
}

BoxSplit::Spread BoxSplit::spread_of(std::span<const std::uint32_t> numbers) const {
  Spread s{centers_[numbers[0]], centers_[numbers[0]], 0};
  for (const std::uint32_t i : numbers) {
    const Lanes& c = centers_[i];
    s.low = c < s.low ? c : s.low;
    s.high = c > s.high ? c : s.high;
  }
  for (std::size_t axis = 1; axis < 3; ++axis)
    if (s.high[axis] - s.low[axis] > s.high[s.widest] - s.low[s.widest]) s.widest = axis;
  return s;
}

std::size_t BoxSplit::arrange(std::span<std::uint32_t> numbers, std::uint32_t last) {
  std::size_t first = 0;
  std::size_t second = 0;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    // Written to both, kept in one: no branch to guess.
    const std::uint32_t number = numbers[i];
    const bool left = marks_[i] <= last;
    numbers[first] = number;
    kept_[second] = number;
    first += left ? 1 : 0;
    second += left ? 0 : 1;
  }
  std::copy_n(kept_.begin(), second, numbers.begin() + static_cast<std::ptrdiff_t>(first));
  return first;
}

BoxSplit::Halves BoxSplit::by_count(std::span<std::uint32_t> numbers) {
  const std::size_t axis = spread_of(numbers).widest;
  const std::size_t middle = numbers.size() / 2;
  const std::span keys(keys_.data(), numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) keys[i] = {centers_[numbers[i]][axis], numbers[i]};
  std::ranges::nth_element(keys, keys.begin() + static_cast<std::ptrdiff_t>(middle), std::less<>());
  const Key pivot = keys[middle];
  for (std::size_t i = 0; i < numbers.size(); ++i)
    marks_[i] = Key{centers_[numbers[i]][axis], numbers[i]} < pivot ? 0 : 1;
  const std::size_t first = arrange(numbers, 0);
  return {first, bounds(numbers.first(first)), bounds(numbers.subspan(first))};
}

BoxSplit::Halves BoxSplit::by_area(std::span<std::uint32_t> numbers) {
  if (numbers.size() == 2) return {1, boxes_[numbers[0]], boxes_[numbers[1]]};
  if (numbers.size() <= kSweepMost) return sweep(numbers);
  const Spread spread = spread_of(numbers);
  if (spread.high[spread.widest] > spread.low[spread.widest]) return bin(numbers, spread);
  return by_count(numbers);
}

BoxSplit::Halves BoxSplit::sweep(std::span<std::uint32_t> numbers) {
  const std::size_t count = numbers.size();
  Halves best{1, FloatBox::none(), FloatBox::none()};
  float least = std::numeric_limits<float>::infinity();
  std::array<std::uint8_t, kSweepMost> best_order{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::array<float, kSweepMost> center;
    std::array<std::uint8_t, kSweepMost> order;
    for (std::size_t i = 0; i < count; ++i) {
      const float c = centers_[numbers[i]][axis];
      std::size_t at = i;
      for (; at > 0 && center[at - 1] > c; --at) {
        center[at] = center[at - 1];
        order[at] = order[at - 1];
      }
      center[at] = c;
      order[at] = static_cast<std::uint8_t>(i);
    }
    std::array<FloatBox, kSweepMost> behind;
    FloatBox right = FloatBox::none();
    for (std::size_t i = count; i-- > 1;) {
      right.add(boxes_[numbers[order[i]]]);
      behind[i] = right;
    }
    FloatBox left = FloatBox::none();
    for (std::size_t i = 1; i < count; ++i) {
      left.add(boxes_[numbers[order[i - 1]]]);
      const float cost =
          left.half_area() * static_cast<float>(i) + behind[i].half_area() * static_cast<float>(count - i);
      if (cost < least) {
        least = cost;
        best = {i, left, behind[i]};
        best_order = order;
      }
    }
  }
  for (std::size_t i = 0; i < count; ++i) marks_[best_order[i]] = i < best.first ? 0 : 1;
  arrange(numbers, 0);
  return best;
}

BoxSplit::Halves BoxSplit::bin(std::span<std::uint32_t> numbers, const Spread& spread) {
  Lanes scale{};
  std::array<std::size_t, 3> axes{};
  std::size_t axis_count = 0;
  const float widest = spread.high[spread.widest] - spread.low[spread.widest];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float extent = spread.high[axis] - spread.low[axis];
    if (extent < widest * kFlat) continue;
    scale[axis] = static_cast<float>(kBins) / extent;
    axes[axis_count++] = axis;
  }
  std::array<std::array<FloatBox, kBins>, 3> boxes;
  std::array<std::array<std::uint32_t, kBins>, 3> counts{};
  for (auto& of_axis : boxes)
    for (FloatBox& box : of_axis) box = FloatBox::none();
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const Lanes& c = centers_[numbers[i]];
    const Lanes place = (c - spread.low) * scale;
    for (std::size_t axis = 0; axis < 4; ++axis) {
      const auto b = static_cast<std::int32_t>(place[axis]);
      bins_[i][axis] = b < static_cast<std::int32_t>(kBins) ? b : static_cast<std::int32_t>(kBins) - 1;
    }
  }
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const FloatBox& box = boxes_[numbers[i]];
    for (std::size_t a = 0; a < axis_count; ++a) {
      const auto b = static_cast<std::size_t>(bins_[i][axes[a]]);
      boxes[axes[a]][b].add(box);
      ++counts[axes[a]][b];
    }
  }
  Halves best{1, FloatBox::none(), FloatBox::none()};
  float least = std::numeric_limits<float>::infinity();
  std::size_t best_axis = spread.widest;
  std::uint32_t last = 0;
  for (std::size_t a = 0; a < axis_count; ++a) {
    const std::size_t axis = axes[a];
    std::array<FloatBox, kBins> behind;
    FloatBox right = FloatBox::none();
    for (std::uint32_t b = kBins; b-- > 1;) {
      right.add(boxes[axis][b]);
      behind[b] = right;
    }
    FloatBox left = FloatBox::none();
    std::size_t first = 0;
    for (std::uint32_t b = 0; b + 1 < kBins; ++b) {
      left.add(boxes[axis][b]);
      first += counts[axis][b];
      if (first == 0 || first == numbers.size()) continue;
      const float cost = left.half_area() * static_cast<float>(first) +
                         behind[b + 1].half_area() * static_cast<float>(numbers.size() - first);
      if (cost < least) {
        least = cost;
        best = {first, left, behind[b + 1]};
        best_axis = axis;
        last = b;
      }
    }
  }
  for (std::size_t i = 0; i < numbers.size(); ++i) marks_[i] = static_cast<std::uint32_t>(bins_[i][best_axis]);
  arrange(numbers, last);
  return best;
}

}  // namespace zc
