// SPDX-License-Identifier: GPL-3.0-or-later
// One building on one parcel: its form, its façade, its roof.
// Units: metres. Thread-safe: no state.
#pragma once

#include <array>
#include <cstdint>

#include "baker/generate/facade.h"
#include "baker/generate/layout.h"

namespace zc::generate {

enum class Form : std::uint8_t { kFlat, kGable, kHip, kEll, kSetback, kCourt };

struct Parcel {
  Rect rect;
  std::array<WallKind, 4> walls;  // south, east, north, west
  double height_m = 12;
  bool ridge_along_x = true;
};

inline constexpr double kBuildingBase = 0.05;  // walls start below the sidewalk's top, so that no gap shows

// A façade that suits the height; `detail` limits its windows.
Facade choose_facade(Rng& rng, double height_m, Detail detail);
// `facade` thinned until the whole wall area keeps to the triangles that one building may spend.
Facade within_budget(Facade facade, double wall_length_m, double height_m, Detail detail);

void add_building(MeshBuilder& mesh, Rng& rng, const Parcel& parcel, Form form, const Facade& facade, Detail detail);

}  // namespace zc::generate
