// SPDX-License-Identifier: Apache-2.0
// Corners of triangles, and arrays with a value for each. Corner c is corner c % 4 of triangle c / 4: of four numbers a
// triangle takes three, so that a shift finds the triangle. Arrays take no memory for the fourth.
// Borrows the arrays. Thread-safe: no state.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace zc {

inline constexpr std::uint32_t kNoCorner = 0xFFFFFFFFU;

inline std::uint32_t first_corner(std::uint32_t triangle) { return 4 * triangle; }
inline std::uint32_t first_corner_beside(std::uint32_t c) { return c & ~3U; }
inline std::uint32_t next_corner(std::uint32_t c) { return (c & 3U) == 2 ? c - 2 : c + 1; }
inline std::uint32_t previous_corner(std::uint32_t c) { return (c & 3U) == 0 ? c + 2 : c - 1; }

// By corner, in an array by triangle.
template <class Triangle>
class CornersOfTriangles {
 public:
  explicit CornersOfTriangles(std::span<Triangle> triangles) : triangles_(triangles) {}
  [[nodiscard]] std::uint32_t triangle_count() const { return static_cast<std::uint32_t>(triangles_.size()); }
  [[nodiscard]] auto& operator[](std::uint32_t c) const { return triangles_[c >> 2U][c & 3U]; }

 private:
  std::span<Triangle> triangles_;
};
using VertexOfCorner = CornersOfTriangles<std::array<std::uint32_t, 3>>;
using ConstVertexOfCorner = CornersOfTriangles<const std::array<std::uint32_t, 3>>;

// By corner, in a flat array of three words a triangle.
class WordOfCorner {
 public:
  explicit WordOfCorner(std::span<std::uint32_t> words) : words_(words) {}
  [[nodiscard]] std::uint32_t& operator[](std::uint32_t c) const { return words_[c - (c >> 2U)]; }
  [[nodiscard]] std::span<std::uint32_t> words() const { return words_; }

 private:
  std::span<std::uint32_t> words_;
};

}  // namespace zc
