// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/generate/buildings.h"

#include <algorithm>
#include <cmath>

namespace zc::generate {
namespace {

constexpr Mat kWarmWalls[] = {Mat::kBrickRed,   Mat::kBrickRed,    Mat::kBrickBrown,   Mat::kOchre,
                              Mat::kSandstone,  Mat::kSandstone,   Mat::kPlasterWhite, Mat::kPlasterCream,
                              Mat::kPastelBlue, Mat::kPastelGreen, Mat::kPastelPink};
constexpr Mat kOfficeWalls[] = {Mat::kConcreteGrey, Mat::kSandstone, Mat::kPlasterWhite, Mat::kConcreteDark,
                                Mat::kBrickBrown};
constexpr Mat kBases[] = {Mat::kConcreteGrey, Mat::kSandstone, Mat::kConcreteDark, Mat::kPlasterCream};
constexpr Mat kAwnings[] = {Mat::kAwningRed, Mat::kAwningBlue, Mat::kAwningCream};
constexpr Mat kRoofs[] = {Mat::kRoofGravel, Mat::kRoofGravel, Mat::kRoofBitumen};
constexpr Mat kTiles[] = {Mat::kRoofTile, Mat::kRoofTile, Mat::kRoofSlate, Mat::kCopperGreen};

Facade residential(Rng& rng) {
  Facade f;
  f.ground_m = rng.range(3.6, 4.2);
  f.storey_m = rng.range(3, 3.4);
  f.sill_m = 0.85;
  f.window_m = rng.range(1.5, 1.9);
  f.bay_m = rng.range(2.9, 3.8);
  f.share = rng.range(0.42, 0.54);
  f.recess_m = rng.chance(0.5) ? 0.1 : 0;
  f.wall = rng.pick(kWarmWalls);
  f.base = rng.pick(kBases);
  f.band = rng.chance(0.25) ? Mat::kPlasterWhite : f.wall;
  f.awnings = rng.chance(0.45);
  f.blinds = true;
  return f;
}

Facade office(Rng& rng) {
  Facade f;
  f.ground_m = rng.range(4.2, 5);
  f.storey_m = rng.range(3.5, 3.8);
  f.sill_m = 0.8;
  f.window_m = rng.range(1.9, 2.3);
  f.bay_m = rng.range(4.5, 7.5);
  f.share = rng.range(0.72, 0.9);
  f.wall = rng.pick(kOfficeWalls);
  f.base = rng.chance(0.5) ? Mat::kConcreteDark : f.wall;
  f.band = rng.chance(0.4) ? Mat::kPlasterWhite : f.wall;
  f.glass = rng.chance(0.5) ? Mat::kGlassDark : Mat::kGlassBlue;
  return f;
}

Facade curtain(Rng& rng) {
  static constexpr Mat kPanes[] = {Mat::kGlassBlue, Mat::kGlassMirror, Mat::kGlassMirror, Mat::kGlassBronze,
                                   Mat::kGlassDark};
  Facade f;
  f.ground_m = 5;
  f.storey_m = rng.range(3.6, 4);
  f.sill_m = 0.2;
  f.window_m = f.storey_m - 0.5;
  f.bay_m = rng.range(3.2, 5.2);
  f.share = 0.93;
  f.wall = f.base = f.band = rng.chance(0.6) ? Mat::kMetalDark : Mat::kMetalGalvanised;
  f.glass = rng.pick(kPanes);
  f.shop_glass = Mat::kGlassDark;
  f.door = Mat::kMetalMirror;
  return f;
}

void add_roof_house(MeshBuilder& mesh, Rng& rng, const Rect& r, double roof_z) {
  if (r.width() < 7 || r.height() < 7) return;
  const double w = rng.range(2.4, 3.6);
  const double x = rng.range(r.x0 + 1.2, r.x1 - 1.2 - w);
  const double y = rng.range(r.y0 + 1.2, r.y1 - 1.2 - w);
  mesh.box({x, y, roof_z - 0.1}, {x + w, y + w, roof_z + rng.range(1.4, 2.6)}, Mat::kConcreteGrey, Mat::kRoofBitumen);
  if (r.width() > 11) {
    const double ax = x > r.center().x ? r.x0 + 1.4 : r.x1 - 3;
    mesh.box({ax, y, roof_z - 0.1}, {ax + 1.6, y + 1.2, roof_z + 0.9}, Mat::kMetalGalvanised);
  }
}

struct Flat {
  double base_z, floor_z, roof_z;
  bool on_ground;
};

void add_flat_body(MeshBuilder& mesh, Rng& rng, const Polygon& outline, std::vector<WallKind> walls, const Flat& z,
                   const Facade& facade, Detail detail, Mat roof) {
  const double parapet = detail == Detail::kCoarse ? 0.4 : 0.8;
  emit_walls(mesh, rng, {outline, std::move(walls), z.base_z, z.floor_z, z.roof_z + parapet, z.roof_z, z.on_ground},
             facade);
  emit_flat_roof(mesh, outline, z.roof_z, z.roof_z + parapet, facade.band, roof);
  if (!z.on_ground) mesh.cap(outline, z.base_z, facade.wall, false);
}

void add_ridged(MeshBuilder& mesh, Rng& rng, const Parcel& p, bool hip, const Facade& facade, Detail detail) {
  const Rect& r = p.rect;
  Polygon outline = r.polygon();
  std::vector<WallKind> walls(p.walls.begin(), p.walls.end());
  if (!p.ridge_along_x) {
    std::rotate(outline.begin(), outline.begin() + 1, outline.end());
    std::rotate(walls.begin(), walls.begin() + 1, walls.end());
  }
  const double span = p.ridge_along_x ? r.height() : r.width();
  const double run = p.ridge_along_x ? r.width() : r.height();
  const double eave = kKerb + p.height_m;
  const double ridge = eave + span / 2 * rng.range(0.55, 0.85);
  const Mat tiles = rng.pick(kTiles);
  emit_walls(mesh, rng, {outline, std::move(walls), kBuildingBase, kKerb, eave, eave, true}, facade);
  emit_ridge_roof(mesh, outline, eave, ridge, hip ? std::min(span / 2, run / 2 - 0.5) : 0, tiles, facade.wall);
  if (detail == Detail::kCoarse || rng.chance(0.3)) return;
  const Vec2 c = r.center() + (p.ridge_along_x ? Vec2{run * 0.2, span * 0.12} : Vec2{span * 0.12, run * 0.2});
  mesh.box({c.x - 0.4, c.y - 0.35, ridge - span * 0.3}, {c.x + 0.4, c.y + 0.35, ridge + 0.9}, Mat::kBrickBrown);
}

void add_ell(MeshBuilder& mesh, Rng& rng, const Parcel& p, const Facade& facade, Detail detail) {
  // The rectangle without one of its corners; the new walls are windows.
  const Rect& r = p.rect;
  const double cx = r.width() * rng.range(0.42, 0.55);
  const double cy = r.height() * rng.range(0.42, 0.55);
  const auto& [s, e, n, w] = p.walls;
  const WallKind k = WallKind::kWindows;
  Polygon outline;
  std::vector<WallKind> walls;
  if (rng.chance(0.5)) {
    outline = {{r.x0, r.y0}, {r.x1, r.y0}, {r.x1, r.y1 - cy}, {r.x1 - cx, r.y1 - cy}, {r.x1 - cx, r.y1}, {r.x0, r.y1}};
    walls = {s, e, k, k, n, w};
  } else {
    outline = {{r.x0, r.y0}, {r.x1, r.y0}, {r.x1, r.y1}, {r.x0 + cx, r.y1}, {r.x0 + cx, r.y1 - cy}, {r.x0, r.y1 - cy}};
    walls = {s, e, n, k, k, w};
  }
  const double roof_z = kKerb + p.height_m;
  add_flat_body(mesh, rng, outline, walls, {kBuildingBase, kKerb, roof_z, true}, facade, detail, rng.pick(kRoofs));
}

void add_setback(MeshBuilder& mesh, Rng& rng, const Parcel& p, const Facade& facade, Detail detail) {
  const double podium = std::min(p.height_m * 0.35, rng.range(9, 16));
  double roof_z = kKerb + podium;
  const Mat roof = rng.pick(kRoofs);
  add_flat_body(mesh, rng, p.rect.polygon(), {p.walls.begin(), p.walls.end()}, {kBuildingBase, kKerb, roof_z, true},
                facade, detail, roof);
  Rect r = p.rect.inset(std::min(p.rect.width(), p.rect.height()) * rng.range(0.12, 0.2));
  const double top = kKerb + p.height_m;
  const int tiers = p.height_m > 55 ? 2 : 1;
  for (int tier = 0; tier < tiers; ++tier) {
    const double next = tier + 1 == tiers ? top : roof_z + (top - roof_z) * rng.range(0.55, 0.75);
    // The tier sinks a hand's breadth into the roof below: both stay closed and none shows a seam.
    add_flat_body(mesh, rng, r.polygon(), std::vector<WallKind>(4, WallKind::kWindows),
                  {roof_z - 0.1, roof_z, next, false}, facade, detail, roof);
    roof_z = next;
    if (tier + 1 < tiers) r = r.inset(std::min(r.width(), r.height()) * 0.12);
  }
  add_roof_house(mesh, rng, r, roof_z);
  if (p.height_m > 80) {
    const Vec2 c = r.center();
    mesh.tube({c, roof_z - 0.1}, {c, roof_z + 14}, 0.35, 0.1, 6, Mat::kMetalGalvanised);
  }
}

void add_court(MeshBuilder& mesh, Rng& rng, const Parcel& p, const Facade& facade) {
  const Polygon outer = p.rect.polygon();
  const Rect yard = p.rect.inset(std::min(p.rect.width(), p.rect.height()) * 0.3);
  const Polygon hole = yard.polygon();
  const double roof_z = kKerb + p.height_m;
  const double parapet_z = roof_z + 0.8;
  emit_walls(mesh, rng, {outer, {p.walls.begin(), p.walls.end()}, kBuildingBase, kKerb, parapet_z, roof_z, true},
             facade);
  const Polygon clockwise(hole.rbegin(), hole.rend());
  emit_walls(mesh, rng,
             {clockwise, std::vector<WallKind>(4, WallKind::kWindows), kBuildingBase, kKerb, parapet_z, roof_z, true},
             facade);
  const Polygon inner = inset_polygon(outer, 0.3);
  const Polygon yard_edge = inset_polygon(hole, -0.3);
  mesh.ring(outer, inner, parapet_z, facade.band);
  mesh.walls(inner, roof_z, parapet_z, facade.band, false);
  mesh.ring(inner, yard_edge, roof_z, rng.pick(kRoofs));
  mesh.walls(yard_edge, roof_z, parapet_z, facade.band);
  mesh.ring(yard_edge, hole, parapet_z, facade.band);
}

}  // namespace

Facade choose_facade(Rng& rng, double height_m, Detail detail) {
  const double roll = rng.unit();
  Facade f;
  if (height_m > 40) {
    f = roll < 0.65 ? curtain(rng) : office(rng);
  } else if (height_m > 20) {
    f = roll < 0.2 ? curtain(rng) : roll < 0.6 ? office(rng) : residential(rng);
  } else {
    f = roll < 0.12 ? office(rng) : residential(rng);
  }
  f.door = rng.chance(0.5) ? f.door : Mat::kDoorGreen;
  f.awning = rng.pick(kAwnings);
  if (detail != Detail::kFull) {
    f.recess_m = 0;
    f.awnings = false;
  }
  return f;
}

Facade within_budget(Facade f, double wall_length_m, double height_m, Detail detail) {
  static constexpr double kTriangles[] = {620, 280, 150};
  const double limit = (height_m > 45 ? 4 : height_m > 22 ? 1.5 : 1) * kTriangles[static_cast<std::size_t>(detail)];
  const auto cost = [&] {
    const double rows = std::max(1.0, (height_m - f.ground_m) / f.storey_m);
    return rows * (wall_length_m / f.bay_m * (f.recess_m > 0 ? 16 : 8) + 16);
  };
  // First the reveals go, then windows widen, then rows join.
  if (cost() > limit) f.recess_m = 0;
  while (cost() > limit && f.bay_m < 7) f.bay_m *= 1.15;
  while (cost() > limit && f.storey_m < 16) {
    f.window_m += f.storey_m * 0.25;
    f.storey_m *= 1.25;
    f.bay_m *= 1.12;
  }
  if (detail == Detail::kCoarse) f.ground_m = 0;
  return f;
}

void add_building(MeshBuilder& mesh, Rng& rng, const Parcel& p, Form form, const Facade& chosen, Detail detail) {
  double length = 0;
  const double sides[] = {p.rect.width(), p.rect.height(), p.rect.width(), p.rect.height()};
  for (std::size_t i = 0; i < 4; ++i) length += p.walls[i] == WallKind::kBlind ? 0 : sides[i];
  if (form == Form::kCourt) length *= 1.4;
  const Facade facade = within_budget(chosen, length, p.height_m, detail);
  switch (form) {
    case Form::kGable:
      add_ridged(mesh, rng, p, false, facade, detail);
      break;
    case Form::kHip:
      add_ridged(mesh, rng, p, true, facade, detail);
      break;
    case Form::kEll:
      add_ell(mesh, rng, p, facade, detail);
      break;
    case Form::kSetback:
      add_setback(mesh, rng, p, facade, detail);
      break;
    case Form::kCourt:
      add_court(mesh, rng, p, facade);
      break;
    case Form::kFlat:
      add_flat_body(mesh, rng, p.rect.polygon(), {p.walls.begin(), p.walls.end()},
                    {kBuildingBase, kKerb, kKerb + p.height_m, true}, facade, detail, rng.pick(kRoofs));
      if (detail != Detail::kCoarse) add_roof_house(mesh, rng, p.rect, kKerb + p.height_m);
      break;
  }
}

}  // namespace zc::generate
