// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/generate/facade.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "base/check.h"

namespace zc::generate {
namespace {

// Evenly spread openings, `share` of each bay, in a wall of the given length.
std::vector<Opening> bays(double length, double bay_m, double share, Mat mat, double recess_m) {
  std::vector<Opening> out;
  if (length < 2) return out;
  const int count = std::max(1, static_cast<int>(length / bay_m + 0.25));
  const double bay = length / count;
  const double half = std::min(bay * share, bay - 0.3) / 2;
  for (int i = 0; i < count; ++i) {
    const double middle = bay * (i + 0.5);
    out.push_back({middle - half, middle + half, mat, recess_m});
  }
  return out;
}

void add_ground_rows(std::vector<WallRow>& rows, Rng& rng, const Body& body, const Facade& f, WallKind kind,
                     double length) {
  const double plinth_z = body.floor_z + 0.55;
  WallRow low{body.base_z, plinth_z, {}, f.base, f.base};
  WallRow high{plinth_z, body.floor_z + f.ground_m - 0.75, {}, f.base, f.base};
  if (kind == WallKind::kShop || kind == WallKind::kHouse) {
    const bool shop = kind == WallKind::kShop;
    high.openings =
        bays(length, shop ? 4.2 : f.bay_m, shop ? 0.82 : f.share, shop ? f.shop_glass : f.glass, f.recess_m);
    low.openings = high.openings;
    for (Opening& o : low.openings) o = {o.u0, o.u1, f.base, 0};
    if (!low.openings.empty()) {
      const auto door = static_cast<std::size_t>(rng.below(static_cast<int>(low.openings.size())));
      // Two leaves in a shop's bay would be four metres wide: keep the shop's glass and give it a narrow door instead.
      Opening& lower = low.openings[door];
      Opening& upper = high.openings[door];
      if (shop) {
        const Opening window{lower.u0 + 1.5, lower.u1, upper.mat, 0};
        lower.u1 = upper.u1 = lower.u0 + 1.2;
        lower.mat = upper.mat = f.door;
        upper.recess_m = 0;
        if (window.u1 - window.u0 > 0.5) {
          const auto next = static_cast<std::ptrdiff_t>(door) + 1;
          low.openings.insert(low.openings.begin() + next, {window.u0, window.u1, f.base, 0});
          high.openings.insert(high.openings.begin() + next, window);
        }
      } else {
        lower.mat = upper.mat = f.door;
        upper.recess_m = 0;
      }
    }
  } else if (kind == WallKind::kWindows) {
    high.openings = bays(length, f.bay_m * 1.5, f.share * 0.8, f.glass, f.recess_m);
    low.openings = high.openings;
    for (Opening& o : low.openings) o = {o.u0, o.u1, f.base, 0};
  }
  rows.push_back(std::move(low));
  rows.push_back(std::move(high));
}

void emit_awning(MeshBuilder& mesh, Vec2 a, Vec2 dir, const Opening& o, double z, Mat m) {
  // A closed wedge whose back lies inside the wall.
  const Vec2 out = {dir.y, -dir.x};
  const auto at = [&](double u, double depth, double height) { return Vec3{a + dir * u + out * depth, height}; };
  const double u0 = o.u0 - 0.1;
  const double u1 = o.u1 + 0.1;
  const Vec3 b0 = at(u0, -0.05, z - 0.15), f0 = at(u0, 1.3, z - 0.15), t0 = at(u0, -0.05, z + 0.5);
  const Vec3 b1 = at(u1, -0.05, z - 0.15), f1 = at(u1, 1.3, z - 0.15), t1 = at(u1, -0.05, z + 0.5);
  mesh.triangle(b0, f0, t0, m);
  mesh.triangle(b1, t1, f1, m);
  mesh.quad(f0, f1, t1, t0, m);
  mesh.quad(b0, b1, f1, f0, m);
  mesh.quad(b0, t0, t1, b1, m);
}

}  // namespace

void emit_wall(MeshBuilder& mesh, Vec2 a, Vec2 b, double z0, double z1, std::span<const WallRow> rows, Mat top_band) {
  const double length = glm::distance(a, b);
  const Vec2 dir = (b - a) / length;
  const Vec2 in = {-dir.y, dir.x};
  const auto at = [&](double u, double z, double depth = 0) {
    return Vec3{u == length ? b + in * depth : a + dir * u + in * depth, z};
  };
  const auto chain = [&](const std::vector<double>& us, double z) {
    std::vector<Vec3> points;
    points.reserve(us.size());
    for (const double u : us) points.push_back(at(u, z));
    return points;
  };
  std::vector<double> below = {0, length};
  double below_z = z0;
  for (const WallRow& row : rows) {
    std::vector<double> breaks = {0};
    for (const Opening& o : row.openings) breaks.insert(breaks.end(), {o.u0, o.u1});
    breaks.push_back(length);
    if (row.z0 > below_z) mesh.strip(chain(below, below_z), chain(breaks, row.z0), row.band_below);
    double u = 0;
    for (const Opening& o : row.openings) {
      ZC_CHECK(o.u0 > u && o.u1 > o.u0 && o.u1 < length);
      mesh.quad(at(u, row.z0), at(o.u0, row.z0), at(o.u0, row.z1), at(u, row.z1), row.pier);
      const std::array<Vec3, 4> rim = {at(o.u0, row.z0), at(o.u1, row.z0), at(o.u1, row.z1), at(o.u0, row.z1)};
      if (o.recess_m > 0) {
        const double d = o.recess_m;
        const std::array<Vec3, 4> pane = {at(o.u0, row.z0, d), at(o.u1, row.z0, d), at(o.u1, row.z1, d),
                                          at(o.u0, row.z1, d)};
        for (std::size_t k = 0; k < 4; ++k) {
          const std::size_t next = (k + 1) % 4;
          mesh.quad(rim[k], rim[next], pane[next], pane[k], row.pier);
        }
        mesh.quad(pane[0], pane[1], pane[2], pane[3], o.mat);
      } else {
        mesh.quad(rim[0], rim[1], rim[2], rim[3], o.mat);
      }
      u = o.u1;
    }
    mesh.quad(at(u, row.z0), at(length, row.z0), at(length, row.z1), at(u, row.z1), row.pier);
    below = std::move(breaks);
    below_z = row.z1;
  }
  if (z1 > below_z) mesh.strip(chain(below, below_z), std::vector<Vec3>{at(0, z1), at(length, z1)}, top_band);
}

void emit_walls(MeshBuilder& mesh, Rng& rng, const Body& body, const Facade& f) {
  const bool ground_floor = body.on_ground && f.ground_m > 0;
  for (std::size_t i = 0; i < body.outline.size(); ++i) {
    const Vec2 a = body.outline[i];
    const Vec2 b = body.outline[(i + 1) % body.outline.size()];
    const double length = glm::distance(a, b);
    std::vector<WallRow> rows;
    if (ground_floor) add_ground_rows(rows, rng, body, f, body.walls[i], length);
    const bool windows = body.walls[i] != WallKind::kBlind;
    double z = body.floor_z + (ground_floor ? f.ground_m : 0);
    for (; z + f.sill_m + f.window_m + 0.25 <= body.storeys_top_z; z += f.storey_m) {
      WallRow row{z + f.sill_m, z + f.sill_m + f.window_m, {}, f.wall, f.band};
      if (windows) row.openings = bays(length, f.bay_m, f.share, f.glass, f.recess_m);
      if (f.blinds) {
        for (Opening& o : row.openings) {
          if (rng.chance(0.1)) o.mat = Mat::kWindowBlind;
        }
      }
      rows.push_back(std::move(row));
    }
    emit_wall(mesh, a, b, body.base_z, body.top_z, rows, f.wall);
    if (ground_floor && f.awnings && body.walls[i] == WallKind::kShop) {
      for (const Opening& o : rows[1].openings) {
        if (o.mat == f.shop_glass && o.u1 - o.u0 > 2) emit_awning(mesh, a, (b - a) / length, o, rows[1].z1, f.awning);
      }
    }
  }
}

void emit_flat_roof(MeshBuilder& mesh, std::span<const Vec2> outline, double roof_z, double parapet_z, Mat parapet,
                    Mat roof) {
  const Polygon inner = inset_polygon(outline, 0.3);
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const std::size_t k = (i + 1) % outline.size();
    mesh.quad({outline[i], parapet_z}, {outline[k], parapet_z}, {inner[k], parapet_z}, {inner[i], parapet_z}, parapet);
  }
  mesh.walls(inner, roof_z, parapet_z, parapet, false);
  mesh.cap(inner, roof_z, roof);
}

void emit_ridge_roof(MeshBuilder& mesh, std::span<const Vec2> outline, double eave_z, double ridge_z, double inset,
                     Mat roof, Mat gable) {
  ZC_CHECK(outline.size() == 4);
  const Vec2 along = glm::normalize(outline[1] - outline[0]);
  const Vec3 p0{outline[0], eave_z}, p1{outline[1], eave_z}, p2{outline[2], eave_z}, p3{outline[3], eave_z};
  const Vec3 r1{(outline[1] + outline[2]) / 2.0 - along * inset, ridge_z};
  const Vec3 r0{(outline[3] + outline[0]) / 2.0 + along * inset, ridge_z};
  mesh.quad(p0, p1, r1, r0, roof);
  mesh.quad(p2, p3, r0, r1, roof);
  const Mat end = inset > 0 ? roof : gable;
  mesh.triangle(p1, p2, r1, end);
  mesh.triangle(p3, p0, r0, end);
}

}  // namespace zc::generate
