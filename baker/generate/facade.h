// SPDX-License-Identifier: GPL-3.0-or-later
// Walls with windows, cut so that the mesh is closed: every window is a hole in the wall's grid that its glass fills,
// never a picture laid over it. Bands between window rows and piers between windows share all their corners.
// Units: metres. Thread-safe: no state.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "baker/generate/mesh_builder.h"
#include "baker/generate/rng.h"

namespace zc::generate {

// What a wall faces: that decides its ground floor, and whether it has windows at all.
enum class WallKind : std::uint8_t { kShop, kHouse, kWindows, kBlind };

struct Facade {
  double ground_m = 4;    // height of the ground floor; 0 when it is a floor like the others
  double storey_m = 3.2;  // from one window row to the next
  double sill_m = 0.9;
  double window_m = 1.6;  // height
  double bay_m = 3.6;
  double share = 0.42;  // of a bay that is glass
  double recess_m = 0;
  Mat wall = Mat::kPlasterWhite;
  Mat base = Mat::kConcreteGrey;  // ground floor
  Mat band = Mat::kPlasterWhite;  // between window rows
  Mat glass = Mat::kGlassDark;
  Mat shop_glass = Mat::kGlassDark;
  Mat door = Mat::kDoorWood;
  Mat awning = Mat::kAwningRed;
  bool awnings = false;
  bool blinds = false;  // some windows are covered
};

// One upright part of a building: its outline and the heights that its walls run between.
struct Body {
  Polygon outline;
  std::vector<WallKind> walls;  // one per edge
  double base_z = 0;
  double floor_z = 0;        // level that storeys are counted from
  double top_z = 0;          // wall tops
  double storeys_top_z = 0;  // no window above
  bool on_ground = true;
};

void emit_walls(MeshBuilder& mesh, Rng& rng, const Body& body, const Facade& facade);

// A roof inside a parapet: the walls end at parapet_z, the roof lies at roof_z.
void emit_flat_roof(MeshBuilder& mesh, std::span<const Vec2> outline, double roof_z, double parapet_z, Mat parapet,
                    Mat roof);

// Over a rectangle whose ridge runs along its first edge; inset 0 makes gables (of gable material), more makes hips.
void emit_ridge_roof(MeshBuilder& mesh, std::span<const Vec2> outline, double eave_z, double ridge_z, double inset,
                     Mat roof, Mat gable);

// Piers, window panes and frames of one wall whose rows are given outright; for the landmarks.
struct Opening {
  double u0 = 0, u1 = 0;  // along the wall
  Mat mat = Mat::kGlassDark;
  double recess_m = 0;
};
struct WallRow {
  double z0 = 0, z1 = 0;
  std::vector<Opening> openings;  // by rising u, not touching
  Mat pier = Mat::kPlasterWhite;
  Mat band_below = Mat::kPlasterWhite;
};
// Outward is to the right of a -> b. A row that starts where the row below ends must have the same openings' edges.
void emit_wall(MeshBuilder& mesh, Vec2 a, Vec2 b, double z0, double z1, std::span<const WallRow> rows, Mat top_band);

}  // namespace zc::generate
