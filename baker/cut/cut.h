// SPDX-License-Identifier: GPL-3.0-or-later
// Cuts a snapped scene into a quadtree of zones. Whole objects go to the cell that contains the centre of their box;
// ground, and objects too large for one zone, are clipped exactly on the lattice along cell borders.
// Points on a border are rounded, once, to the coarsest step of all nodes that may touch there, computed from the edge
// alone: both sides of a border and both faces of an edge get bit-identical points, and no level moves them again.
// Owns what it returns. Deterministic at any thread count.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "baker/repair/snap.h"

namespace zc {

struct Zone {
  std::uint32_t depth = 0;
  std::uint32_t cell_x = 0;
  std::uint32_t cell_y = 0;
  std::int32_t parent = -1;
  std::vector<std::uint32_t> children;  // none: a leaf
  LatticeMesh detail;                   // of a leaf: its full-detail geometry, welded
  std::array<float, 2> moved = {};      // steps that rounded borders lie off the source at most; [1]: of the ground

  [[nodiscard]] float most_moved() const { return std::max(moved[0], moved[1]); }
};

// The arithmetic of cells and borders; lengths in steps.
struct CellGrid {
  std::uint32_t root_log2 = 0;      // the root cell is [0, 2^root_log2)^2
  std::uint32_t min_cell_log2 = 0;  // no cell is smaller
  std::int64_t overhang = 0;        // how far whole objects may reach beyond their cell, both sides together, at most
  std::int64_t height = 0;          // of the world

  [[nodiscard]] std::int64_t cell_size(std::uint32_t depth) const { return std::int64_t{1} << (root_log2 - depth); }
  // Bound of step_shift over all nodes at this depth and below.
  [[nodiscard]] std::uint32_t step_shift_bound(std::uint32_t depth) const;
  // Step shift of points on the border plane through `coordinate`; 0 where no border can be.
  [[nodiscard]] std::uint32_t border_shift(std::int32_t coordinate) const;
  [[nodiscard]] bool may_be_border(std::int32_t coordinate) const;
  [[nodiscard]] bool can_split(std::uint32_t depth) const;
  // Whether p lies on a plane between cells of the zone's size: a zone may be several of them.
  [[nodiscard]] bool on_cell_border(const Zone& zone, const LatticePoint& p) const;
};

struct ZoneTree {
  CellGrid grid;
  std::vector<Zone> zones;  // breadth first; siblings contiguous; zone 0 is the root
};

// What stays together has at most so many zones' worth of triangles: a zone must stay small against the memory cap.
inline constexpr std::uint64_t kDetailZonesLimit = 4;

// The cells of a whole city, of which a leaf has `leaf_triangles`.
CellGrid fit_cells(const SnappedScene& scene, std::uint32_t leaf_triangles);

// The largest step shift of a leaf at which rounding to its step takes two thirds of `error_m` at most.
std::uint32_t leaf_step_shift(double error_m, double step_m);

// A zone of more triangles than `leaf_triangles`, or so wide that its step would be above `leaf_shift`, is split, as
// far as that makes sense.
struct CutInput {
  SnappedScene scene;
  std::uint32_t leaf_triangles = 0;
  std::uint32_t leaf_shift = 30;
  // Of the whole city:
  CellGrid grid;  // fit_cells
};

// As SnappedScene, with zones for the mesh and its objects.
struct CutScene {
  ZoneTree tree;
  WorldLattice lattice;
  std::vector<Material> materials;
  std::string crs;
  std::vector<ImportCount> notes;  // and what was cut against its kind
};

Result<CutScene> cut_zones(CutInput&& input, BakeContext& context);

}  // namespace zc
