// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/generate/streets.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace zc::generate {
namespace {

constexpr double kTurn = 6.283185307179586;
constexpr int kArcSteps = 4;
constexpr double kLineHalf = 0.075;
constexpr double kKerbTop = 0.25;

std::string cell_name(const char* kind, int i, int j) {
  return std::string(kind) + "_" + std::to_string(i) + "_" + std::to_string(j);
}

// A quarter circle, counter-clockwise from quadrant * 90 degrees; a single point when the radius is 0.
void append_arc(Polygon& out, Vec2 center, double radius, int quadrant) {
  const int steps = radius > 0 ? kArcSteps : 0;
  for (int k = 0; k <= steps; ++k) {
    const double angle = kTurn / 4 * (quadrant + static_cast<double>(k) / kArcSteps);
    out.push_back(center + radius * Vec2{std::cos(angle), std::sin(angle)});
  }
}

// An uneven patch inside the rectangle.
Polygon patch(Rng& rng, const Rect& r, Vec2 center, double reach) {
  Polygon out;
  const double rx = std::min(r.width() / 2, reach * 1.8);
  const double ry = std::min(r.height() / 2, reach);
  for (const Vec2 p : circle({0, 0}, 1, 11)) out.push_back(center + Vec2{p.x * rx, p.y * ry} * rng.range(0.6, 0.95));
  return out;
}

// One lane's share of a period: a rectangle whose edge towards the centre line carries the dash's corners.
void add_lane_cell(MeshBuilder& mesh, Rng& rng, const Rect& r, double dash0, double dash1, bool centre_above) {
  const double edge = centre_above ? r.y1 : r.y0;
  const double roll = rng.unit();
  if (roll > 0.4) {
    const std::vector<Vec3> dashed = {{r.x0, edge, 0}, {dash0, edge, 0}, {dash1, edge, 0}, {r.x1, edge, 0}};
    const double far = centre_above ? r.y0 : r.y1;
    const std::vector<Vec3> plain = {{r.x0, far, 0}, {r.x1, far, 0}};
    mesh.strip(centre_above ? plain : dashed, centre_above ? dashed : plain, Mat::kAsphaltWet);
    return;
  }
  Polygon outer;
  if (centre_above) {
    outer = {{r.x0, r.y0}, {r.x1, r.y0}, {r.x1, edge}, {dash1, edge}, {dash0, edge}, {r.x0, edge}};
  } else {
    outer = {{r.x0, edge}, {dash0, edge}, {dash1, edge}, {r.x1, edge}, {r.x1, r.y1}, {r.x0, r.y1}};
  }
  const Vec2 c = r.center();
  const bool manhole = roll < 0.05;
  const Polygon hole = manhole ? circle(c, 0.34, 10) : patch(rng, r.inset(0.25), c, rng.range(0.8, 2.4));
  mesh.ring(outer, hole, 0, Mat::kAsphaltWet);
  mesh.cap(hole, 0, manhole ? Mat::kManholeIron : roll < 0.24 ? Mat::kAsphaltPuddle : Mat::kAsphaltPatch);
}

// The street's first metres beside a crossing, local x outward from 0; striped for people to cross.
void add_arm(MeshBuilder& mesh, double width, bool striped) {
  const double h = width / 2;
  if (!striped) {
    mesh.quad({0, -h, 0}, {kCornerRadius, -h, 0}, {kCornerRadius, h, 0}, {0, h, 0}, Mat::kAsphaltWet);
    return;
  }
  const double x0 = 0.9, x1 = 4.1;
  const int cells = 2 * static_cast<int>(width / 1.2) + 1;
  const double pitch = width / cells;
  std::vector<Vec3> near, far;
  for (int k = 0; k <= cells; ++k) {
    near.push_back({x0, -h + pitch * k, 0});
    far.push_back({x1, -h + pitch * k, 0});
  }
  mesh.strip(near, std::vector<Vec3>{{0, -h, 0}, {0, h, 0}}, Mat::kAsphaltWet);
  mesh.strip(std::vector<Vec3>{{kCornerRadius, -h, 0}, {kCornerRadius, h, 0}}, far, Mat::kAsphaltWet);
  for (std::size_t k = 0; k + 1 < near.size(); ++k) {
    mesh.quad(near[k], far[k], far[k + 1], near[k + 1], k % 2 == 1 ? Mat::kLaneWhite : Mat::kAsphaltWet);
  }
}

Mat lot_material(const Layout& layout, int i, int j) {
  static constexpr Mat kYards[] = {Mat::kGrass, Mat::kGrass, Mat::kConcreteGrey, Mat::kStoneLight, Mat::kConcreteWet};
  switch (layout.use(i, j)) {
    case BlockUse::kPark:
    case BlockUse::kHouses:
      return Mat::kGrass;
    case BlockUse::kWarehouse:
    case BlockUse::kTireShop:
      return Mat::kConcreteWet;
    case BlockUse::kMirror:
      return Mat::kStoneLight;
    default:
      return Rng(layout.seed, 0x79617264, i, j).pick(kYards);
  }
}

}  // namespace

Segment make_segment(const Layout& layout, bool east, int line, int step) {
  const Line& own = (east ? layout.y : layout.x)[static_cast<std::size_t>(line)];
  const auto& cross = east ? layout.x : layout.y;
  const auto reach = [&](int k) { return east ? layout.reach(k, line) : layout.reach(line, k); };
  const double from = cross[static_cast<std::size_t>(step)].high() + reach(step);
  const double to = cross[static_cast<std::size_t>(step) + 1].low() - reach(step + 1);
  Segment s;
  s.origin = east ? Vec3{from, own.at, 0} : Vec3{own.at, from, 0};
  s.heading = east ? Vec2{1, 0} : Vec2{0, 1};
  s.length = to - from;
  s.width = own.width;
  s.east = east;
  s.line = line;
  s.step = step;
  s.block_right = east ? line > 0 : line < layout.n;
  s.block_left = east ? line < layout.n : line > 0;
  return s;
}

bool is_ramp(const Layout& layout, const Segment& s) {
  return !s.east && s.line == layout.core + 2 && (s.step == layout.core || s.step == layout.core + 1);
}

void add_road_surface(MeshBuilder& mesh, Rng& rng, double x0, double x1, double width, bool full) {
  const double h = width / 2;
  if (!full) {
    mesh.quad({x0, -h, 0}, {x1, -h, 0}, {x1, -kLineHalf, 0}, {x0, -kLineHalf, 0}, Mat::kAsphaltWet);
    mesh.quad({x0, -kLineHalf, 0}, {x1, -kLineHalf, 0}, {x1, kLineHalf, 0}, {x0, kLineHalf, 0}, Mat::kLaneWhite);
    mesh.quad({x0, kLineHalf, 0}, {x1, kLineHalf, 0}, {x1, h, 0}, {x0, h, 0}, Mat::kAsphaltWet);
    return;
  }
  const int periods = std::max(1, static_cast<int>(std::round((x1 - x0) / 9)));
  const double pitch = (x1 - x0) / periods;
  for (int k = 0; k < periods; ++k) {
    const double a = x0 + pitch * k;
    const double b = k + 1 == periods ? x1 : x0 + pitch * (k + 1);
    const double d0 = a + pitch * 0.33, d1 = a + pitch * 0.67;
    add_lane_cell(mesh, rng, {a, -h, b, -kLineHalf}, d0, d1, true);
    add_lane_cell(mesh, rng, {a, kLineHalf, b, h}, d0, d1, false);
    const double xs[] = {a, d0, d1, b};
    for (int c = 0; c < 3; ++c) {
      mesh.quad({xs[c], -kLineHalf, 0}, {xs[c + 1], -kLineHalf, 0}, {xs[c + 1], kLineHalf, 0}, {xs[c], kLineHalf, 0},
                c == 1 ? Mat::kLaneWhite : Mat::kAsphaltWet);
    }
  }
}

void add_road(GlbWriter& glb, const Layout& layout, const Segment& s) {
  if (is_ramp(layout, s)) return;
  Rng rng(layout.seed, s.east ? 0x726F6164 : 0x6E726F61, s.line, s.step);
  MeshBuilder mesh(s.east ? cell_name("road_east", s.step, s.line) : cell_name("road_north", s.line, s.step));
  mesh.set_frame(s.origin, s.heading);
  const Vec2 middle = Vec2{s.origin} + s.heading * (s.length / 2);
  add_road_surface(mesh, rng, 0, s.length, s.width, layout.detail(middle) != Detail::kCoarse);
  glb.add(mesh);
}

void add_crossing(GlbWriter& glb, const Layout& layout, int i, int j) {
  const Line& lx = layout.x[static_cast<std::size_t>(i)];
  const Line& ly = layout.y[static_cast<std::size_t>(j)];
  const bool full = layout.detail({lx.at, ly.at}) == Detail::kFull;
  MeshBuilder mesh(cell_name("road_crossing", i, j));
  Rng rng(layout.seed, 0x63726F73, i, j);
  const Vec3 center = {lx.at, ly.at, 0};
  if (layout.is_bridge(i, j)) {
    mesh.set_frame({lx.low(), ly.at, 0});
    add_road_surface(mesh, rng, 0, lx.width, ly.width, true);
    glb.add(mesh);
    return;
  }
  mesh.set_frame(center);
  const double hx = lx.width / 2, hy = ly.width / 2;
  const Rect square = {-hx, -hy, hx, hy};
  if (full) {
    const Polygon hole = circle({0, 0}, 0.34, 10);
    mesh.ring(square.polygon(), hole, 0, Mat::kAsphaltWet);
    mesh.cap(hole, 0, Mat::kManholeIron);
  } else {
    mesh.cap(square.polygon(), 0, Mat::kAsphaltWet);
  }
  const bool has[] = {i<layout.n, j<layout.n, i> 0, j> 0};  // streets to the east, north, west, south
  static constexpr double kDirX[] = {1, 0, -1, 0}, kDirY[] = {0, 1, 0, -1};
  for (int d = 0; d < 4; ++d) {
    if (!has[d]) continue;
    mesh.set_frame(center + Vec3{kDirX[d] * hx, kDirY[d] * hy, 0}, {kDirX[d], kDirY[d]});
    add_arm(mesh, d % 2 == 0 ? ly.width : lx.width, full);
  }
  mesh.set_frame({0, 0, 0});
  // The rounded corners that the kerbs leave to the road.
  for (int q = 0; q < 4; ++q) {
    if (!has[q] || !has[(q + 1) % 4]) continue;
    const double sx = q == 0 || q == 3 ? 1 : -1, sy = q < 2 ? 1 : -1;
    const Vec2 apex = {lx.at + sx * hx, ly.at + sy * hy};
    Polygon arc;
    append_arc(arc, apex + kCornerRadius * Vec2{sx, sy}, kCornerRadius, (q + 2) % 4);
    for (std::size_t k = 0; k + 1 < arc.size(); ++k) {
      mesh.triangle({apex, 0}, {arc[k + 1], 0}, {arc[k], 0}, Mat::kAsphaltWet);
    }
  }
  glb.add(mesh);
}

void add_sidewalk(GlbWriter& glb, const Layout& layout, int i, int j) {
  const Rect b = layout.block(i, j);
  Polygon outline;
  const double sw = layout.reach(i, j), se = layout.reach(i + 1, j), ne = layout.reach(i + 1, j + 1),
               nw = layout.reach(i, j + 1);
  append_arc(outline, {b.x0 + sw, b.y0 + sw}, sw, 2);
  append_arc(outline, {b.x1 - se, b.y0 + se}, se, 3);
  append_arc(outline, {b.x1 - ne, b.y1 - ne}, ne, 0);
  append_arc(outline, {b.x0 + nw, b.y1 - nw}, nw, 1);
  const Polygon kerb = inset_polygon(outline, kKerbTop);
  const Polygon lot = layout.lot(i, j).polygon();
  MeshBuilder mesh(cell_name("sidewalk", i, j));
  mesh.walls(outline, 0, kKerb, Mat::kKerbStone);
  for (std::size_t k = 0; k < outline.size(); ++k) {
    const std::size_t next = (k + 1) % outline.size();
    mesh.quad({outline[k], kKerb}, {outline[next], kKerb}, {kerb[next], kKerb}, {kerb[k], kKerb}, Mat::kKerbStone);
  }
  mesh.ring(kerb, lot, kKerb, Mat::kConcreteSidewalk);
  if (layout.use(i, j) != BlockUse::kPlaza) mesh.cap(lot, kKerb, lot_material(layout, i, j));
  glb.add(mesh);
}

void add_skirt(GlbWriter& glb, const Layout& layout) {
  const double h = layout.half_size();
  std::vector<double> at = {-h - kSkirt};
  for (int k = 0; k <= layout.n; ++k) at.push_back(-h + 2 * h * k / layout.n);
  at.push_back(h + kSkirt);
  const std::size_t last = at.size() - 2;
  for (std::size_t i = 0; i <= last; ++i) {
    for (std::size_t j = 0; j <= last; ++j) {
      if (i != 0 && i != last && j != 0 && j != last) continue;
      MeshBuilder mesh(cell_name("ground", static_cast<int>(i), static_cast<int>(j)));
      mesh.cap(Rect{at[i], at[j], at[i + 1], at[j + 1]}.polygon(), 0, Mat::kGrass);
      glb.add(mesh);
    }
  }
}

}  // namespace zc::generate
