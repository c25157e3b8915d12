// SPDX-License-Identifier: GPL-3.0-or-later
// A BvhBox or BvhReference as eight 16-bit lanes in which growing is one instruction: all signed, the lower bounds
// inverted, so that both kinds of bound grow by a maximum. Packing loses nothing; a reference keeps its triangle in the
// two lanes that are left, which mean nothing once boxes are joined. Thread-safe: plain values.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <limits>

#include "baker/bvh/binary_tree.h"
#include "base/simd.h"

namespace zc {

class PackedBox {
 public:
  PackedBox() = default;  // empty
  explicit PackedBox(const BvhReference& r) {
    lanes_ = take_lanes<0, 1, 2, 6, 3, 4, 5, 7>(std::bit_cast<Short8>(r)) ^ kFlip;
  }
  explicit PackedBox(const BvhBox& box) : PackedBox(BvhReference{box, 0}) {}
  // Around a point of 16 bits a coordinate, x lowest. Put together in a register: a box that is written to memory in
  // parts is waited for when it is read as a whole.
  static PackedBox around(std::uint64_t p) {
    PackedBox box;
    box.lanes_ = std::bit_cast<Short8>(std::array<std::uint64_t, 2>{p, p}) ^ kFlip;
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
    const auto halves = std::bit_cast<std::array<Short4, 2>>(lanes_);
    return to_floats(to_ints(halves[1]) - to_ints(halves[0]) + 65535);
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
    const auto extents = std::bit_cast<UnsignedShort8>(upper()) + std::bit_cast<UnsignedShort8>(lanes_) + 1;
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
    return std::bit_cast<BvhReference>(take_lanes<0, 1, 2, 4, 5, 6, 3, 7>(lanes_ ^ kFlip));
  }
  [[nodiscard]] BvhBox box() const { return reference().box; }
  [[nodiscard]] std::uint32_t triangle() const { return reference().triangle; }

 private:
  static constexpr std::int16_t kLowest = std::numeric_limits<std::int16_t>::min();
  static constexpr Short8 kFlip = {32767, 32767, 32767, 0, kLowest, kLowest, kLowest, 0};
  static_assert(sizeof(BvhReference) == sizeof(Short8));

  [[nodiscard]] Short8 upper() const { return take_lanes<4, 5, 6, 7, 4, 5, 6, 7>(lanes_); }

  // Lower bounds and half of the triangle, upper bounds and the other half.
  Short8 lanes_ = {kLowest, kLowest, kLowest, 0, kLowest, kLowest, kLowest, 0};
};

}  // namespace zc
