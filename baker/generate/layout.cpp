// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/generate/layout.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "baker/generate/rng.h"

namespace zc::generate {
namespace {

constexpr double kPitch = 98;      // a street and a block, on average
constexpr double kSmallest = 300;  // the core needs this much

std::vector<Line> make_lines(Rng rng, int n, int core, double size_m) {
  std::vector<Line> lines;
  std::vector<double> weights;
  double streets = 0;
  for (int i = 0; i <= n; ++i) {
    static constexpr double kWidths[] = {10, 11, 12};
    lines.push_back({0, rng.pick(kWidths)});
    streets += lines.back().width;
  }
  double total = 0;
  for (int i = 0; i < n; ++i) {
    const bool in_core = i >= core && i < core + 3;
    weights.push_back(in_core ? 1.02 : rng.range(0.87, 1.13));
    total += weights.back();
  }
  double at = -size_m / 2;
  for (int i = 0; i <= n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    lines[k].at = at + lines[k].width / 2;
    at += lines[k].width;
    // Quarter metres; the last block takes what is left over.
    if (i < n) at += std::round((size_m - streets) * weights[k] / total * 4) / 4;
    if (i == n - 1) at = size_m / 2 - lines.back().width;
  }
  return lines;
}

}  // namespace

Rect Layout::block(int i, int j) const {
  const auto a = static_cast<std::size_t>(i);
  const auto b = static_cast<std::size_t>(j);
  return {x[a].high(), y[b].high(), x[a + 1].low(), y[b + 1].low()};
}

BlockUse Layout::use(int i, int j) const {
  const int a = i - core;
  const int b = j - core;
  if (a == 0 && b == 1) return BlockUse::kPlaza;
  if (a == 1 && b == 1) return BlockUse::kHouses;
  if (a == 2 && b == 1) return BlockUse::kWarehouse;
  if (a == 2 && b == 0) return BlockUse::kTireShop;
  if (a == 1 && b == 2) return BlockUse::kMirror;
  if (a >= 0 && a < 3 && b >= 0 && b < 3) return BlockUse::kTown;
  return Rng(seed, 0x7061726B, i, j).chance(0.07) ? BlockUse::kPark : BlockUse::kTown;
}

Detail Layout::detail(Vec2 at) const {
  const double distance_m = glm::length(at);
  return distance_m < 205 ? Detail::kFull : distance_m < 900 ? Detail::kMedium : Detail::kCoarse;
}

Layout make_layout(std::uint64_t seed, double size_m) {
  size_m = std::max(std::round(size_m), kSmallest);
  Layout layout;
  layout.seed = seed;
  layout.n = std::max(3, static_cast<int>(std::round(size_m / kPitch)));
  layout.core = (layout.n - 3) / 2;
  layout.x = make_lines(Rng(seed, 0x6C696E65, 0, 0), layout.n, layout.core, size_m);
  layout.y = make_lines(Rng(seed, 0x6C696E65, 0, 1), layout.n, layout.core, size_m);
  return layout;
}

}  // namespace zc::generate
