// SPDX-License-Identifier: GPL-3.0-or-later
// Where streets, blocks and landmarks lie. Street lines i = 0..n run north (at x) and east (at y); block (i, j) lies
// between lines i, i+1 and j, j+1. The landmarks sit in the 3 x 3 blocks in the middle, whose first block is (core,
// core):
//
//      +--------+--------+--------+   y line core+3
//      |  town  | mirror |  town  |
//      +--------+--------+--------+   y line core+2
//      | plaza  | houses = wareho.|   = ramps of the bridge on x line core+2,
//      +--------+--------+--------+   y line core+1, which runs through the underpass
//      |  town  |  town  = tires  |
//      +--------+--------+--------+   y line core
//
// Units: metres. Thread-safe: plain values.
#pragma once

#include <cstdint>
#include <vector>

#include "baker/generate/mesh_builder.h"

namespace zc::generate {

inline constexpr double kKerb = 0.15;         // height of sidewalks above the road
inline constexpr double kSidewalk = 3;        // width of sidewalks
inline constexpr double kCornerRadius = 5;    // of kerbs; also how far a crossing reaches into its streets
inline constexpr double kUnderpassReach = 9;  // from the street's centre to the abutments
inline constexpr double kDeckTop = 6;         // of the bridge
inline constexpr double kSkirt = 120;         // ground beyond the last street

struct Line {
  double at = 0;     // centre
  double width = 0;  // between kerbs
  [[nodiscard]] double low() const { return at - width / 2; }
  [[nodiscard]] double high() const { return at + width / 2; }
};

enum class BlockUse : std::uint8_t { kTown, kPark, kPlaza, kHouses, kWarehouse, kTireShop, kMirror };

// How much is modelled: far districts of a large city are seen from afar only.
enum class Detail : std::uint8_t { kFull, kMedium, kCoarse };

struct Layout {
  std::uint64_t seed = 1;
  int n = 3;     // blocks per side
  int core = 0;  // first block of the core
  std::vector<Line> x, y;

  [[nodiscard]] double half_size() const { return x.back().high(); }
  [[nodiscard]] Rect block(int i, int j) const;  // between kerbs
  [[nodiscard]] Rect lot(int i, int j) const { return block(i, j).inset(kSidewalk); }
  [[nodiscard]] BlockUse use(int i, int j) const;
  [[nodiscard]] Detail detail(Vec2 at) const;
  // The crossing where one street passes over the other.
  [[nodiscard]] bool is_bridge(int i, int j) const { return i == core + 2 && j == core + 1; }
  // How far the crossing of lines i, j reaches into its streets beyond their kerbs.
  [[nodiscard]] double reach(int i, int j) const { return is_bridge(i, j) ? 0 : kCornerRadius; }
};

Layout make_layout(std::uint64_t seed, double size_m);

}  // namespace zc::generate
