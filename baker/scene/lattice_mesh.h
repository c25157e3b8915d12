// SPDX-License-Identifier: GPL-3.0-or-later
// Triangles whose vertices lie on the world lattice: what every stage between the snap and the encoder works on.
// Units: lattice steps relative to the world's anchor; coordinates stay below 2^30, so that cross products of edge
// vectors are exact in 64 bits. Thread-safe: plain values.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace zc {

using LatticePoint = std::array<std::int32_t, 3>;

inline glm::dvec3 to_dvec(const LatticePoint& p) { return {p[0], p[1], p[2]}; }

// Where a world's lattice lies in its reference system.
struct WorldLattice {
  std::array<std::int64_t, 3> anchor = {};  // steps, whole metres
  std::int32_t step_log2 = -8;              // in [-16, 0]: steps divide the metre, so that the anchor is whole in both

  [[nodiscard]] double step_m() const;
};

// Widest distance of two points of a world, in steps.
inline constexpr std::int64_t kLatticeExtentMax = std::int64_t{1} << 30;

struct LatticeFace {
  std::array<std::uint32_t, 3> v = {};
  std::uint16_t material = 0;
  bool ground = false;  // terrain, roads, water: cut at zone borders and never dropped

  bool operator==(const LatticeFace&) const = default;
};

struct LatticeMesh {
  std::vector<LatticePoint> vertices;
  std::vector<LatticeFace> faces;

  bool operator==(const LatticeMesh&) const = default;
};

struct LatticeBox {
  LatticePoint min = {INT32_MAX, INT32_MAX, INT32_MAX};
  LatticePoint max = {INT32_MIN, INT32_MIN, INT32_MIN};

  void add(const LatticePoint& p);
  void add(const LatticeBox& box);
  [[nodiscard]] bool empty() const { return min[0] > max[0]; }
  [[nodiscard]] double diagonal() const;  // steps
};

LatticeBox bounds_of(const LatticeMesh& mesh);

bool is_degenerate(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c);

double face_area(const LatticeMesh& mesh, const LatticeFace& face);  // square steps

// Vertices rotated so that the smallest comes first; the orientation stays.
std::array<std::uint32_t, 3> rotated(const std::array<std::uint32_t, 3>& v);

// Joins equal points (vertices end sorted, unused ones vanish).
void weld(LatticeMesh& mesh);

// Welds, then drops faces without area and repetitions of a face with the same orientation.
void clean(LatticeMesh& mesh);

// Appends a copy of `other`; vertices are not joined.
void append(LatticeMesh& mesh, const LatticeMesh& other);

// Smallest k for which extents (largest side, in steps) fit 16 bits after aligning the origin to 2^k.
std::uint32_t step_shift_for_extent(std::int64_t extent);
std::uint32_t step_shift_for_box(const LatticeBox& box);

// Nearest multiple of 2^shift, halves upwards.
std::int32_t round_to_step(std::int64_t value, std::uint32_t shift);

// Rounds all vertices to multiples of 2^shift and cleans.
void round_to_step(LatticeMesh& mesh, std::uint32_t shift);

}  // namespace zc
