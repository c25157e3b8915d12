// SPDX-License-Identifier: GPL-3.0-or-later
// The binary BVH that every builder of this folder makes and the collapse to wide nodes consumes: one reference a leaf.
// Coordinates are 16-bit lattice units of one zone, so boxes bound exactly. Thread-safe: plain values.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace zc {

using BvhTriangle = std::array<std::array<std::uint16_t, 3>, 3>;

struct BvhBox {
  std::array<std::uint16_t, 3> min = {65535, 65535, 65535};
  std::array<std::uint16_t, 3> max = {0, 0, 0};

  bool operator==(const BvhBox&) const = default;
  [[nodiscard]] bool empty() const { return min[0] > max[0]; }
  void add(const BvhBox& b) {
    for (std::size_t i = 0; i < 3; ++i) {
      min[i] = std::min(min[i], b.min[i]);
      max[i] = std::max(max[i], b.max[i]);
    }
  }
  [[nodiscard]] bool contains(const BvhBox& b) const {
    for (std::size_t i = 0; i < 3; ++i)
      if (b.min[i] < min[i] || b.max[i] > max[i]) return false;
    return true;
  }
  // Half the surface; exact, below 2^34.
  [[nodiscard]] std::int64_t half_area() const {
    if (empty()) return 0;
    const std::int64_t x = max[0] - min[0];
    const std::int64_t y = max[1] - min[1];
    const std::int64_t z = max[2] - min[2];
    return x * y + y * z + z * x;
  }
};

inline BvhBox box_of(const BvhTriangle& t) {
  BvhBox box;
  for (const auto& corner : t) box.add({corner, corner});
  return box;
}

// A piece of a triangle: all of it, or with spatial splits what lies in `box`.
struct BvhReference {
  BvhBox box;
  std::uint32_t triangle = 0;
};

inline constexpr std::uint32_t kNoChild = 0xFFFFFFFFU;

struct BinaryNode {
  BvhBox box;
  std::uint32_t left = kNoChild;  // the right child follows it; kNoChild: a leaf
  std::uint32_t reference = 0;    // of a leaf
  [[nodiscard]] bool is_leaf() const { return left == kNoChild; }
};

// Node 0 is the root; children lie behind their parents.
struct BinaryTree {
  std::vector<BinaryNode> nodes;
  std::vector<BvhReference> references;
};

}  // namespace zc
