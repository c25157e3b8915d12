// SPDX-License-Identifier: GPL-3.0-or-later
// A BvhBox or BvhReference as eight 16-bit lanes in which growing is one instruction: all signed, the lower bounds
// inverted, so that both kinds of bound grow by a maximum. Packing loses nothing; a reference keeps its triangle in the
// two lanes that are left, which mean nothing once boxes are joined. Uses the vector types that GCC and Clang have on
// every processor. Thread-safe: plain values.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <limits>

#include "baker/bvh/binary_tree.h"

namespace zc {

using Float4 = float __attribute__((vector_size(16)));
using Int4 = std::int32_t __attribute__((vector_size(16)));

class PackedBox {
 public:
  PackedBox() = default;  // empty
  explicit PackedBox(const BvhReference& r) {
    const auto lanes = std::bit_cast<Lanes>(r);
    lanes_ = __builtin_shufflevector(lanes, lanes, 0, 1, 2, 6, 3, 4, 5, 7) ^ kFlip;
  }
  explicit PackedBox(const BvhBox& box) : PackedBox(BvhReference{box, 0}) {}
  // Around a point of 16 bits a coordinate, x lowest. Put together in a register: a box that is written to memory in
  // parts is waited for when it is read as a whole.
  static PackedBox around(std::uint64_t p) {
    PackedBox box;
    box.lanes_ = std::bit_cast<Lanes>(std::array<std::uint64_t, 2>{p, p}) ^ kFlip;
    return box;
  }
  static PackedBox around(const std::array<std::uint16_t, 3>& p) {
    return around(std::uint64_t{p[0]} | std::uint64_t{p[1]} << 16U | std::uint64_t{p[2]} << 32U);
  }

  void add(const PackedBox& b) { lanes_ = lanes_ > b.lanes_ ? lanes_ : b.lanes_; }
  void clip(const PackedBox& b) { lanes_ = lanes_ < b.lanes_ ? lanes_ : b.lanes_; }

  [[nodiscard]] std::uint32_t min(std::size_t axis) const { return static_cast<std::uint32_t>(32767 - lanes_[axis]); }
  [[nodiscard]] std::uint32_t max(std::size_t axis) const {
    return static_cast<std::uint32_t>(32768 + lanes_[axis + 4]);
  }
  [[nodiscard]] std::uint32_t center(std::size_t axis) const { return min(axis) + max(axis); }  // doubled
  [[nodiscard]] Float4 centers() const {  // likewise, exact; the last lane means nothing
    const auto halves = std::bit_cast<std::array<Lanes4, 2>>(lanes_);
    return __builtin_convertvector(
        __builtin_convertvector(halves[1], Int4) - __builtin_convertvector(halves[0], Int4) + 65535, Float4);
  }
  bool operator==(const PackedBox& b) const {
    using Halves = std::array<std::uint64_t, 2>;
    return std::bit_cast<Halves>(lanes_) == std::bit_cast<Halves>(b.lanes_);
  }
  [[nodiscard]] bool empty() const {
    // Upper bounds are kept less by 2^15, lower ones L as 32767 - L: L > U where the complement of the one is more.
    const auto crossed = std::bit_cast<std::array<std::uint64_t, 2>>(~lanes_ > upper());
    return (crossed[0] & 0xFFFFFFFFFFFFU) != 0;
  }
  // Half the surface of a box that is not empty: exact, below 2^34.
  [[nodiscard]] std::int64_t half_area() const {
    // Unsigned: extents are below 2^16, and sums of the lanes wrap to them.
    const auto extents = std::bit_cast<UnsignedLanes>(upper()) + std::bit_cast<UnsignedLanes>(lanes_) + 1;
    const std::uint64_t v = std::bit_cast<std::array<std::uint64_t, 2>>(extents)[0];
    const std::uint64_t x = v & 0xFFFFU;
    const std::uint64_t y = v >> 16U & 0xFFFFU;
    const std::uint64_t z = v >> 32U & 0xFFFFU;
    return static_cast<std::int64_t>(x * (y + z) + y * z);
  }
  // That of an empty box is zero.
  [[nodiscard]] std::int64_t area() const { return empty() ? 0 : half_area(); }
  [[nodiscard]] std::int32_t extent(std::size_t axis) const { return lanes_[axis] + lanes_[axis + 4] + 1; }

  [[nodiscard]] BvhReference reference() const {
    const Lanes lanes = lanes_ ^ kFlip;
    return std::bit_cast<BvhReference>(__builtin_shufflevector(lanes, lanes, 0, 1, 2, 4, 5, 6, 3, 7));
  }
  [[nodiscard]] BvhBox box() const { return reference().box; }
  [[nodiscard]] std::uint32_t triangle() const { return reference().triangle; }

 private:
  using Lanes = std::int16_t __attribute__((vector_size(16)));
  using UnsignedLanes = std::uint16_t __attribute__((vector_size(16)));
  using Lanes4 = std::int16_t __attribute__((vector_size(8)));
  static constexpr std::int16_t kLowest = std::numeric_limits<std::int16_t>::min();
  static constexpr Lanes kFlip = {32767, 32767, 32767, 0, kLowest, kLowest, kLowest, 0};
  static_assert(sizeof(BvhReference) == sizeof(Lanes));

  [[nodiscard]] Lanes upper() const { return __builtin_shufflevector(lanes_, lanes_, 4, 5, 6, 7, 4, 5, 6, 7); }

  // Lower bounds and half of the triangle, upper bounds and the other half.
  Lanes lanes_ = {kLowest, kLowest, kLowest, 0, kLowest, kLowest, kLowest, 0};
};

}  // namespace zc
