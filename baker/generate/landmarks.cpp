// SPDX-License-Identifier: GPL-3.0-or-later
// Tire shop, warehouse, mirror building and the coloured houses that the mirrors show.
#include "baker/generate/landmarks.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <string>

#include "baker/generate/blocks.h"
#include "baker/generate/buildings.h"
#include "baker/generate/furniture.h"

namespace zc::generate {
namespace {

constexpr double kEave = 8.5;

double whole(double v) { return std::round(v); }

// Trapezoid ribs of sheet metal from a to b, outward to the right; the ends lie on the line itself.
void add_ribs(MeshBuilder& mesh, Vec2 a, Vec2 b, double z0, double z1) {
  const double length = glm::distance(a, b);
  const Vec2 dir = (b - a) / length;
  const Vec2 out = {dir.y, -dir.x};
  const int ribs = std::max(1, static_cast<int>(length / 1.2));
  const double pitch = length / ribs;
  std::vector<Vec2> line = {a};
  for (int k = 0; k < ribs; ++k) {
    for (const auto& [share, depth] : {std::pair{0.3, 0.0}, {0.42, 0.14}, {0.88, 0.14}, {1.0, 0.0}}) {
      line.push_back(k + 1 == ribs && share == 1.0 ? b : a + dir * (pitch * (k + share)) + out * depth);
    }
  }
  for (std::size_t k = 0; k + 1 < line.size(); ++k) {
    mesh.quad({line[k], z0}, {line[k + 1], z0}, {line[k + 1], z1}, {line[k], z1}, Mat::kMetalCorrugated);
  }
}

// A closed gable along y that rests over walls which end inside it.
void add_hall_roof(MeshBuilder& mesh, const Rect& r, double z0) {
  const double m = r.center().x;
  const std::vector<Vec2> section = {{r.x0, z0}, {r.x1, z0}, {r.x1, z0 + 0.35}, {m, z0 + 3.6}, {r.x0, z0 + 0.35}};
  for (std::size_t k = 0; k < section.size(); ++k) {
    const Vec2 p = section[k], q = section[(k + 1) % section.size()];
    const bool slope = k == 2 || k == 3;
    mesh.quad({p.x, r.y0, p.y}, {p.x, r.y1, p.y}, {q.x, r.y1, q.y}, {q.x, r.y0, q.y},
              slope ? Mat::kRoofSlate : Mat::kMetalDark);
  }
  for (std::size_t k = 1; k + 1 < section.size(); ++k) {
    const Vec2 a = section[0], b = section[k], c = section[k + 1];
    mesh.triangle({a.x, r.y0, a.y}, {b.x, r.y0, b.y}, {c.x, r.y0, c.y}, Mat::kMetalCorrugated);
    mesh.triangle({a.x, r.y1, a.y}, {c.x, r.y1, c.y}, {b.x, r.y1, b.y}, Mat::kMetalCorrugated);
  }
}

void add_containers(GlbWriter& glb, Rng& rng, const Rect& yard) {
  static constexpr Mat kPaints[] = {Mat::kAwningBlue, Mat::kHouseCoral, Mat::kPaintGreen,
                                    Mat::kOchre,      Mat::kHouseTeal,  Mat::kConcreteGrey};
  int count = 0;
  for (double y = yard.y0; y + 12.2 < yard.y1; y += 15) {
    for (double x = yard.x0; x + 2.44 < yard.x1; x += 2.9) {
      const int high = rng.below(4);
      for (int k = 0; k < high; ++k) {
        MeshBuilder mesh("container_" + std::to_string(count++));
        const double z = k == 0 ? kKerb - 0.02 : kKerb + 2.6 * k;
        const double slide = rng.range(-0.3, 0.3);
        mesh.box({x, y + slide, z}, {x + 2.44, y + slide + 12.2, kKerb + 2.6 * (k + 1) - 0.01}, rng.pick(kPaints));
        glb.add(mesh);
      }
    }
  }
}

}  // namespace

Rect tire_shop_rect(const Layout& layout) {
  const Rect lot = layout.lot(layout.core + 2, layout.core);
  const double x = whole(lot.center().x);
  return {x - 12, lot.y1 - 24, x + 12, lot.y1 - 10};
}

Rect warehouse_rect(const Layout& layout) {
  const Rect lot = layout.lot(layout.core + 2, layout.core + 1);
  return {lot.x1 - 40, lot.y0 + 10, lot.x1 - 7, lot.y1 - 10};
}

Rect mirror_rect(const Layout& layout) {
  const Rect lot = layout.lot(layout.core + 1, layout.core + 2);
  const double x = whole(lot.center().x);
  return {x - 20, lot.y0, x + 20, lot.y0 + 18};
}

void add_tire_shop(GlbWriter& glb, const Layout& layout, std::span<const Shot> shots) {
  const Rect r = tire_shop_rect(layout);
  const double roof = kKerb + 4.9;
  const double parapet = roof + 0.9;
  Rng rng(layout.seed, 0x74697265, 0, 0);
  MeshBuilder mesh("tire_shop");
  const Polygon outline = r.polygon();
  const auto wall = [&](std::size_t k, std::vector<Opening> openings, double sill) {
    const std::vector<WallRow> rows = {
        {sill, kKerb + 3.9, std::move(openings), Mat::kPlasterWhite, Mat::kConcreteDark}};
    emit_wall(mesh, outline[k], outline[(k + 1) % 4], kBuildingBase, parapet, rows, Mat::kPaintRed);
  };
  // Every wall has its row at the same heights, so the corners agree.
  const double sill = kKerb + 0.12;
  wall(0, {}, sill);
  wall(1, {{2, 5, Mat::kGlassDark, 0}, {6, 9, Mat::kGlassDark, 0}}, sill);
  // Seen from the street the wall runs from right to left: showroom, showroom, showroom, door, two roller doors.
  wall(2,
       {{0.5, 5.1, Mat::kGlassDark, 0.1},
        {5.3, 9.9, Mat::kGlassDark, 0.1},
        {10.1, 13.4, Mat::kGlassDark, 0.1},
        {14.2, 18.4, Mat::kMetalMirror, 0.25},
        {19.2, 23.4, Mat::kMetalMirror, 0.25}},
       sill);
  wall(3, {}, sill);
  emit_flat_roof(mesh, outline, roof, parapet, Mat::kPaintRed, Mat::kRoofGravel);
  mesh.box({r.x0 + 2, r.y1 - 0.1, kKerb + 4.3}, {r.x0 + 12, r.y1 + 0.25, kKerb + 5.4}, Mat::kPaintYellow);
  for (int k = 0; k < 5; ++k) {
    const double x = r.x0 + 2.8 + 1.8 * k;
    mesh.torus({x + 0.6, r.y1 + 0.3, kKerb + 4.85}, {0, 1, 0}, 0.28, 0.1, 12, 5, Mat::kTyreRubber);
  }
  const Vec3 crown = {r.x1 - 4, r.y1 - 1.5, parapet + 1.25};
  mesh.torus(crown, {0, 1, 0}, 1.15, 0.5, 20, 8, Mat::kTyreRubber);
  mesh.tube(crown + Vec3{0, -0.2, 0}, crown + Vec3{0, 0.2, 0}, 0.75, 0.75, 16, Mat::kMetalGalvanised);
  mesh.box({r.x1 - 4.5, r.y1 - 2, roof - 0.1}, {r.x1 - 3.5, r.y1 - 1, parapet - 0.3}, Mat::kMetalDark);
  glb.add(mesh);

  int count = 0;
  const auto stack = [&](double x, double y, int high) {
    MeshBuilder m("tyre_stack_" + std::to_string(count++));
    add_tyre_stack(m, rng, {x, y, kKerb}, high);
    glb.add(m);
  };
  for (int k = 0; k < 4; ++k) stack(r.x1 + 0.9, r.y1 - 1 - 0.85 * k, 5 + rng.below(3));
  for (const double x : {r.x0 + 10.1, r.x0 + 14.2, r.x0 + 18.9}) stack(x, r.y1 + 0.9, 3 + rng.below(3));
  for (int k = 0; k < 3; ++k) stack(r.x0 - 1 - 0.8 * k, r.y1 + 1, 4 + rng.below(3));
  stack(r.x1 + 0.4, r.y1 + 1.8, 2);
  stack(r.x1 + 1.2, r.y1 + 2.4, 3);
  for (const double x : {r.x0 + 2.6, r.x0 + 7.4, r.x1 + 6}) {
    const Vec2 at = {x, r.y1 + 4.2};
    if (blocks_view(shots, at, 2)) continue;
    MeshBuilder car("shop_car_" + std::to_string(count++));
    add_car(car, rng, {{at, kKerb}, {0, -1}});
    glb.add(car);
  }
  // Houses stand on the far half of the block.
  const Rect lot = layout.lot(layout.core + 2, layout.core);
  BlockSite site{layout.core + 2, layout.core};
  add_house_row(glb, layout, site, {lot.x0, lot.y0, lot.x1, lot.y0 + 13}, 0, {12, 19});
  add_house_row(glb, layout, site, {lot.x0, lot.y0 + 16, lot.x0 + 12, r.y0 + 2}, 3, {9, 13});
}

void add_warehouse(GlbWriter& glb, const Layout& layout) {
  const Rect r = warehouse_rect(layout);
  MeshBuilder mesh("warehouse");
  const Polygon p = r.polygon();
  const double z0 = kBuildingBase, z1 = kEave + 0.2;  // wall tops end inside the roof
  add_ribs(mesh, p[0], p[1], z0, z1);
  add_ribs(mesh, p[2], p[3], z0, z1);
  add_ribs(mesh, p[3], p[0], z0, z1);
  // East: a flat middle with three mirror-bright doors and a band of windows over them.
  const double middle = whole(r.center().y);
  const Vec2 a = {r.x1, middle - 14}, b = {r.x1, middle + 14};
  add_ribs(mesh, p[1], a, z0, z1);
  add_ribs(mesh, b, p[2], z0, z1);
  const std::vector<WallRow> rows = {
      {kKerb + 0.02,
       kKerb + 5,
       {{1.5, 8.5, Mat::kMetalMirror, 0.2}, {10.5, 17.5, Mat::kMetalMirror, 0.2}, {19.5, 26.5, Mat::kMetalMirror, 0.2}},
       Mat::kMetalDark,
       Mat::kMetalDark},
      {kKerb + 6,
       kKerb + 7.3,
       {{1.5, 8.5, Mat::kGlassBlue, 0.1}, {10.5, 17.5, Mat::kGlassBlue, 0.1}, {19.5, 26.5, Mat::kGlassBlue, 0.1}},
       Mat::kMetalCorrugated,
       Mat::kPaintYellow}};
  emit_wall(mesh, a, b, z0, z1, rows, Mat::kMetalCorrugated);
  for (const Vec2 corner : p) {
    mesh.box({corner.x - 0.18, corner.y - 0.18, z0}, {corner.x + 0.18, corner.y + 0.18, z1}, Mat::kMetalDark);
  }
  const Rect roof = r.inset(-0.6);
  add_hall_roof(mesh, roof, kEave);
  glb.add(mesh);

  const Rect lot = layout.lot(layout.core + 2, layout.core + 1);
  Rng rng(layout.seed, 0x77617265, 0, 0);
  add_containers(glb, rng, {lot.x0 + 4, lot.y0 + 12, r.x0 - 6, lot.y1 - 8});
  int count = 0;
  for (const double y : {r.y0 + 4, middle + 9, r.y1 - 3}) {
    MeshBuilder bollard("dock_bollard_" + std::to_string(count++));
    add_bollard(bollard, {r.x1 + 1, y, kKerb});
    glb.add(bollard);
  }
}

void add_mirror_building(GlbWriter& glb, const Layout& layout) {
  const Rect r = mirror_rect(layout);
  const double roof = kKerb + 14.6;
  const double parapet = roof + 0.6;
  MeshBuilder mesh("mirror_window");
  const Polygon outline = r.polygon();
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec2 a = outline[k], b = outline[(k + 1) % 4];
    const double length = glm::distance(a, b);
    const int panes = k == 0 ? 8 : static_cast<int>(length / 4.5);
    const double pitch = length / panes;
    std::vector<WallRow> rows;
    for (int floor = 0; floor < 3; ++floor) {
      const double z = kKerb + 0.35 + 4.75 * floor;
      WallRow row{z, z + 4.5, {}, Mat::kMetalDark, Mat::kMetalDark};
      for (int n = 0; n < panes; ++n) {
        const bool door = k == 0 && floor == 0 && (n == 3 || n == 4);
        row.openings.push_back(
            {pitch * n + 0.12, pitch * (n + 1) - 0.12, door ? Mat::kGlassDark : Mat::kGlassMirror, 0});
      }
      rows.push_back(std::move(row));
    }
    emit_wall(mesh, a, b, kBuildingBase, parapet, rows, Mat::kMetalDark);
  }
  emit_flat_roof(mesh, outline, roof, parapet, Mat::kMetalDark, Mat::kRoofGravel);
  mesh.box({r.x0 + 14, r.y0 + 6, roof - 0.1}, {r.x0 + 22, r.y0 + 12, roof + 2.4}, Mat::kMetalGalvanised);
  glb.add(mesh);

  const Rect lot = layout.lot(layout.core + 1, layout.core + 2);
  BlockSite site{layout.core + 1, layout.core + 2};
  add_house_row(glb, layout, site, {lot.x0, lot.y0, r.x0 - 3, lot.y0 + 13}, 0, {13, 18});
  add_house_row(glb, layout, site, {r.x1 + 3, lot.y0, lot.x1, lot.y0 + 13}, 0, {13, 18});
  add_detached(glb, layout, site, {lot.x0, lot.y0 + 26, lot.x1, lot.y1}, 22);
}

void add_coloured_houses(GlbWriter& glb, const Layout& layout) {
  const Rect lot = layout.lot(layout.core + 1, layout.core + 1);
  BlockSite site{layout.core + 1, layout.core + 1};
  add_house_row(glb, layout, site, {lot.x0, lot.y1 - 12, lot.x1, lot.y1}, 2, {8.5, 11.5, 7, 9.5, true});
  add_house_row(glb, layout, site, {lot.x0, lot.y0, lot.x1, lot.y0 + 13}, 0, {13, 21});
  add_house_row(glb, layout, site, {lot.x0, lot.y0 + 17, lot.x0 + 12, lot.y1 - 16}, 3, {11, 16});
  Rng rng(layout.seed, 0x79617264, 1, 1);
  const Vec2 c = lot.center();
  MeshBuilder trees("yard_trees_houses");
  for (int k = 0; k < 5; ++k)
    add_tree(trees, rng, {c.x + rng.range(-16, 28), c.y + rng.range(-10, 10), kKerb}, rng.range(6, 10));
  glb.add(trees);
}

}  // namespace zc::generate
