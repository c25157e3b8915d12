// SPDX-License-Identifier: Apache-2.0
// Halves a set of boxes by the surface area heuristic: exactly where there are few (a sweep over every place), by bins
// where there are many (Wald 2007, "On fast construction of SAH-based bounding volume hierarchies").
// Works in floats: what it decides may be a hair off the best, what comes of it is made of the exact boxes elsewhere.
// Deterministic: halves keep the order that their boxes came in, and equal ones fall by it. Threads: one at a time.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/simd.h"
#include "shaders/shared/page_node.h"

namespace zc {

// Four lanes, so that a box is two vector registers; the last one is idle. Without a value until it is given one.
struct FloatBox {
  using Lanes = Float4;
  Lanes low, high;

  static FloatBox none() { return {Lanes{} + 1e30F, Lanes{} - 1e30F}; }
  void add(const FloatBox& b) {
    low = b.low < low ? b.low : low;
    high = b.high > high ? b.high : high;
  }
  [[nodiscard]] float half_area() const {
    const float x = high[0] - low[0];
    const float y = high[1] - low[1];
    const float z = high[2] - low[2];
    return x * y + y * z + z * x;
  }
};
NodeBox to_node_box(const FloatBox& box);  // as near as floats are

class BoxSplit {
 public:
  // Numbers below are places in `boxes`.
  void begin(std::span<const NodeBox> boxes);
  // Takes memory for so many boxes at once: kBytesPerBox each, and no more as long as there are no more.
  void reserve(std::size_t boxes);

  struct Halves {
    std::size_t first;  // how many belong to the first half
    FloatBox left, right;
  };
  [[nodiscard]] const FloatBox& box(std::uint32_t number) const { return boxes_[number]; }
  [[nodiscard]] FloatBox bounds(std::span<const std::uint32_t> numbers) const;

  // Both rearrange at least two numbers.
  Halves by_area(std::span<std::uint32_t> numbers);
  Halves by_count(std::span<std::uint32_t> numbers);

 private:
  using Lanes = FloatBox::Lanes;
  struct Key {
    float center;
    std::uint32_t number;
    bool operator<(const Key& b) const { return center != b.center ? center < b.center : number < b.number; }
  };
  struct Spread {
    Lanes low, high;  // of the centres
    std::size_t widest;
  };

  [[nodiscard]] Spread spread_of(std::span<const std::uint32_t> numbers) const;
  Halves sweep(std::span<std::uint32_t> numbers);
  Halves bin(std::span<std::uint32_t> numbers, const Spread& spread);
  // Those with a mark of at most `last` first.
  std::size_t arrange(std::span<std::uint32_t> numbers, std::uint32_t last);

  using Bins = std::array<std::int32_t, 4>;

  std::vector<FloatBox> boxes_;
  std::vector<Lanes> centers_;        // doubled
  std::vector<Bins> bins_;            // by place in the set being split, per axis
  std::vector<std::uint32_t> marks_;  // the same, of the axis that was chosen
  std::vector<std::uint32_t> kept_;
  std::vector<Key> keys_;

 public:
  static constexpr std::uint64_t kBytesPerBox =
      sizeof(FloatBox) + sizeof(Lanes) + sizeof(Bins) + 2 * sizeof(std::uint32_t) + sizeof(Key);
};

}  // namespace zc
