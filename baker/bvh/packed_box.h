// SPDX-License-Identifier: GPL-3.0-or-later
// A BvhBox or BvhReference as eight 16-bit lanes in which growing is one instruction: all signed, the lower bounds
// inverted, so that both kinds of bound grow by a maximum. Packing is an exclusive or and loses nothing; a reference keeps
// its triangle in the last two lanes, which mean nothing once boxes are joined.
// Uses the vector types that GCC and Clang have on every processor. Thread-safe: plain values.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <limits>

#include "baker/bvh/binary_tree.h"

namespace zc {

class PackedBox {
 public:
  PackedBox() = default;  // empty
  explicit PackedBox(const BvhReference& r) : lanes_(std::bit_cast<Lanes>(r) ^ kFlip) {}
  explicit PackedBox(const BvhBox& box) : PackedBox(BvhReference{box, 0}) {}

  void add(const PackedBox& b) { lanes_ = lanes_ > b.lanes_ ? lanes_ : b.lanes_; }
  void clip(const PackedBox& b) { lanes_ = lanes_ < b.lanes_ ? lanes_ : b.lanes_; }

  [[nodiscard]] std::uint32_t min(std::size_t axis) const { return static_cast<std::uint32_t>(32767 - lanes_[axis]); }
  [[nodiscard]] std::uint32_t max(std::size_t axis) const { return static_cast<std::uint32_t>(32768 + lanes_[axis + 3]); }
  [[nodiscard]] std::uint32_t center(std::size_t axis) const { return min(axis) + max(axis); }  // doubled
  bool operator==(const PackedBox& b) const {
    using Halves = std::array<std::uint64_t, 2>;
    return std::bit_cast<Halves>(lanes_) == std::bit_cast<Halves>(b.lanes_);
  }
  [[nodiscard]] bool empty() const { return min(0) > max(0) || min(1) > max(1) || min(2) > max(2); }
  // Half the surface of a box that is not empty: exact, below 2^34.
  [[nodiscard]] std::int64_t half_area() const {
    const Lanes extents = __builtin_shufflevector(lanes_, lanes_, 3, 4, 5, 0, 0, 0, 0, 0) + lanes_ + kOne;
    const std::uint64_t v = std::bit_cast<std::array<std::uint64_t, 2>>(extents)[0];
    const std::uint64_t x = v & 0xFFFFU;
    const std::uint64_t y = v >> 16U & 0xFFFFU;
    const std::uint64_t z = v >> 32U & 0xFFFFU;
    return static_cast<std::int64_t>(x * (y + z) + y * z);
  }
  // That of an empty box is zero.
  [[nodiscard]] std::int64_t area() const { return empty() ? 0 : half_area(); }
  [[nodiscard]] std::int32_t extent(std::size_t axis) const { return lanes_[axis] + lanes_[axis + 3] + 1; }

  [[nodiscard]] BvhReference reference() const { return std::bit_cast<BvhReference>(lanes_ ^ kFlip); }
  [[nodiscard]] BvhBox box() const { return reference().box; }
  [[nodiscard]] std::uint32_t triangle() const { return reference().triangle; }

 private:
  using Lanes = std::int16_t __attribute__((vector_size(16)));
  static constexpr std::int16_t kLowest = std::numeric_limits<std::int16_t>::min();
  static constexpr Lanes kFlip = {32767, 32767, 32767, kLowest, kLowest, kLowest, 0, 0};
  static constexpr Lanes kOne = {1, 1, 1, 1, 1, 1, 1, 1};
  static_assert(sizeof(BvhReference) == sizeof(Lanes));

  Lanes lanes_ = {kLowest, kLowest, kLowest, kLowest, kLowest, kLowest, 0, 0};
};

}  // namespace zc
