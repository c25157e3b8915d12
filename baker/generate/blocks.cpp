// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/generate/blocks.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>

#include "baker/generate/buildings.h"
#include "baker/generate/furniture.h"

namespace zc::generate {
namespace {

Rng site_rng(const Layout& layout, const BlockSite& site) {
  return {layout.seed, 0x626C6400ULL + static_cast<std::uint64_t>(site.next), site.i, site.j};
}

MeshBuilder next_building(BlockSite& site) {
  return MeshBuilder("building_" + std::to_string(site.i) + "_" + std::to_string(site.j) + "_" +
                     std::to_string(site.next++));
}

// Taller towards the middle of the city, from about 9 m at its edge to about 42 m.
double typical_height(const Layout& layout, Vec2 at) {
  const double d = std::min(1.0, glm::length(at) / layout.half_size());
  return 9 + 33 * (1 - d) * (1 - d * 0.4);
}

constexpr Form kRowForms[] = {Form::kFlat, Form::kFlat, Form::kFlat, Form::kGable, Form::kHip, Form::kGable};
constexpr Mat kColours[] = {Mat::kHouseYellow, Mat::kHouseCoral, Mat::kHouseTeal,   Mat::kPlasterWhite,
                            Mat::kHouseBlue,   Mat::kPastelPink, Mat::kPastelGreen, Mat::kOchre};

void add_one_detached(GlbWriter& glb, const Layout& layout, BlockSite& site, const Rect& r, double height_m) {
  Rng rng = site_rng(layout, site);
  const Detail detail = layout.detail(r.center());
  const WallKind street = height_m > 9 && rng.chance(0.6) ? WallKind::kShop : WallKind::kHouse;
  Parcel p{r, {street, WallKind::kWindows, street, WallKind::kWindows}, height_m, r.width() > r.height()};
  const double small = std::min(r.width(), r.height());
  Form form = Form::kFlat;
  if (height_m > 34) {
    form = Form::kSetback;
  } else if (small > 26 && rng.chance(0.6)) {
    form = Form::kCourt;
  } else if (small > 15 && rng.chance(0.45)) {
    form = Form::kEll;
  } else if (height_m < 16 && small < 22) {
    form = rng.chance(0.5) ? Form::kHip : Form::kGable;
  }
  const Facade facade = choose_facade(rng, height_m, detail);
  MeshBuilder mesh = next_building(site);
  add_building(mesh, rng, p, form, facade, detail);
  glb.add(mesh);
}

void split(GlbWriter& glb, const Layout& layout, BlockSite& site, Rng& rng, const Rect& r, double height_m) {
  const double longest = std::max(r.width(), r.height());
  if (longest < 28 || (longest < 42 && rng.chance(0.3))) {
    double h = height_m * rng.range(0.65, 1.35);
    if (rng.chance(0.1)) h *= 1.7;
    add_one_detached(glb, layout, site, r, std::max(6.5, h));
    return;
  }
  const double gap = rng.quarters(4, 8);
  const double cut = rng.range(0.4, 0.6);
  Rect a = r;
  Rect b = r;
  if (r.width() > r.height()) {
    const double x = std::round((r.x0 + r.width() * cut) * 4) / 4;
    a.x1 = x - gap / 2;
    b.x0 = x + gap / 2;
  } else {
    const double y = std::round((r.y0 + r.height() * cut) * 4) / 4;
    a.y1 = y - gap / 2;
    b.y0 = y + gap / 2;
  }
  split(glb, layout, site, rng, a, height_m);
  split(glb, layout, site, rng, b, height_m);
}

void add_perimeter(GlbWriter& glb, const Layout& layout, BlockSite& site, Rng& rng, const Rect& lot, double height_m) {
  const double depth = rng.quarters(12, 15.5);
  const RowStyle style{height_m * 0.75, height_m * 1.2, 13, 23, false, true};
  add_house_row(glb, layout, site, {lot.x0, lot.y0, lot.x1, lot.y0 + depth}, 0, style);
  add_house_row(glb, layout, site, {lot.x0, lot.y1 - depth, lot.x1, lot.y1}, 2, style);
  // Passages of 3.5 m lead into the yard at the rows' ends.
  const double y0 = lot.y0 + depth + 3.5;
  const double y1 = lot.y1 - depth - 3.5;
  if (y1 - y0 < 14) return;
  add_house_row(glb, layout, site, {lot.x1 - depth, y0, lot.x1, y1}, 1, style);
  add_house_row(glb, layout, site, {lot.x0, y0, lot.x0 + depth, y1}, 3, style);
  // Most yards are built up in turn.
  const Rect yard = {lot.x0 + depth + 7, y0 + 3, lot.x1 - depth - 7, y1 - 3};
  if (yard.width() > 14 && yard.height() > 14 && rng.chance(0.6)) {
    const double third = std::round(yard.height() / 3);
    add_one_detached(glb, layout, site, {yard.x0, yard.y0 + third, yard.x1, yard.y1},
                     std::max(6.5, height_m * rng.range(0.35, 0.7)));
    return;
  }
  const Vec2 c = lot.center();
  if (layout.detail(c) != Detail::kCoarse) {
    MeshBuilder trees("yard_trees_" + std::to_string(site.i) + "_" + std::to_string(site.j));
    for (int k = 0; k < 5; ++k) {
      add_tree(trees, rng, {c.x + rng.range(-12, 12), c.y + rng.range(-14, 14), kKerb}, rng.range(6, 10), k < 2);
    }
    glb.add(trees);
  }
}

}  // namespace

void add_house_row(GlbWriter& glb, const Layout& layout, BlockSite& site, const Rect& strip, int front,
                   const RowStyle& style) {
  const bool along_x = front == 0 || front == 2;
  const double length = along_x ? strip.width() : strip.height();
  Rng rng(layout.seed, 0x726F7700ULL + static_cast<std::uint64_t>(site.next), site.i, site.j);
  double at = 0;
  bool first = true;
  std::size_t colour = static_cast<std::size_t>(rng.below(8));
  while (length - at > 0.5) {
    double width = rng.quarters(style.width_low_m, style.width_high_m);
    if (length - at - width < style.width_low_m)
      width = length - at > 1.7 * style.width_low_m && length - at > width ? std::round((length - at) * 2) / 4
                                                                           : length - at;
    const bool last = length - at - width < 0.5;
    const Rect r = along_x ? Rect{strip.x0 + at, strip.y0, strip.x0 + at + width, strip.y1}
                           : Rect{strip.x0, strip.y0 + at, strip.x1, strip.y0 + at + width};
    const Detail detail = layout.detail(r.center());
    const double height = std::max(5.8, rng.range(style.height_low_m, style.height_high_m));
    Parcel p{r, {}, height, along_x};
    p.walls.fill(WallKind::kBlind);
    const WallKind street = rng.chance(0.6) && !style.colourful ? WallKind::kShop : WallKind::kHouse;
    p.walls[static_cast<std::size_t>(front)] = street;
    p.walls[static_cast<std::size_t>((front + 2) % 4)] = WallKind::kWindows;
    const WallKind end = style.ends_open ? WallKind::kWindows : WallKind::kBlind;
    if (first) p.walls[along_x ? 3 : 0] = end;
    if (last) p.walls[along_x ? 1 : 2] = end;
    Facade facade = choose_facade(rng, height, detail);
    Form form = height > 20 ? Form::kFlat : rng.pick(kRowForms);
    if (form == Form::kHip && !(first && last)) form = Form::kGable;
    if (style.colourful) {
      facade = choose_facade(rng, 0, detail);
      facade.wall = facade.band = kColours[colour % 8];
      facade.base = rng.chance(0.5) ? Mat::kPlasterWhite : facade.wall;
      facade.recess_m = 0.1;
      facade.bay_m = 3;
      form = Form::kGable;
      p.ridge_along_x = !along_x;
      colour += 1 + static_cast<std::size_t>(rng.below(3));
    }
    MeshBuilder mesh = next_building(site);
    add_building(mesh, rng, p, form, facade, detail);
    glb.add(mesh);
    at += width;
    first = false;
  }
}

void add_detached(GlbWriter& glb, const Layout& layout, BlockSite& site, const Rect& lot, double height_m) {
  Rng rng = site_rng(layout, site);
  split(glb, layout, site, rng, lot, height_m);
}

void add_town_block(GlbWriter& glb, const Layout& layout, int i, int j) {
  Rng rng(layout.seed, 0x746F776E, i, j);
  const Rect lot = layout.lot(i, j);
  const double height = typical_height(layout, lot.center());
  const double nearness = 1 - std::min(1.0, glm::length(lot.center()) / layout.half_size());
  BlockSite site{i, j};
  const double roll = rng.unit();
  const bool in_core = i >= layout.core && i < layout.core + 3 && j >= layout.core && j < layout.core + 3;
  if (roll < 0.16 + 0.55 * nearness && !(in_core && (i + j) % 2 == 1)) {
    // A tower over one half, detached houses over the other.
    const bool left = rng.chance(0.5);
    const double middle = std::round(lot.center().x);
    const Rect tower = {left ? lot.x0 : middle + 3, lot.y0 + 4, left ? middle - 3 : lot.x1,
                        lot.y0 + 4 + std::min(46.0, lot.height() * 0.55)};
    add_one_detached(glb, layout, site, tower, std::min(120.0, rng.range(45, 75) + 55 * nearness));
    add_detached(glb, layout, site, {tower.x0, tower.y1 + 8, tower.x1, lot.y1}, height);
    add_detached(glb, layout, site, {left ? middle + 3 : lot.x0, lot.y0, left ? lot.x1 : middle - 3, lot.y1},
                 height * 1.2);
  } else if (roll < 0.75) {
    add_perimeter(glb, layout, site, rng, lot, height * rng.range(0.75, 1));
  } else {
    add_detached(glb, layout, site, lot, height);
  }
}

void add_park_block(GlbWriter& glb, const Layout& layout, int i, int j) {
  Rng rng(layout.seed, 0x7472656573, i, j);
  const Rect lot = layout.lot(i, j).inset(3);
  const Detail detail = layout.detail(lot.center());
  const int count = detail == Detail::kFull ? 28 : detail == Detail::kMedium ? 14 : 6;
  MeshBuilder trees("park_trees_" + std::to_string(i) + "_" + std::to_string(j));
  for (int k = 0; k < count; ++k) {
    add_tree(trees, rng, {rng.range(lot.x0, lot.x1), rng.range(lot.y0, lot.y1), kKerb}, rng.range(6, 13),
             detail != Detail::kCoarse);
  }
  glb.add(trees);
}

}  // namespace zc::generate
