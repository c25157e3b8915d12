// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <string>

#include "baker/generate/furniture.h"
#include "baker/generate/landmarks.h"

namespace zc::generate {
namespace {

// Polished fields between narrow rough bands.
std::vector<double> paving_lines(double from, double to) {
  const int fields = std::max(1, static_cast<int>(std::round((to - from) / 9.5)));
  const double pitch = (to - from) / fields;
  std::vector<double> lines;
  for (int k = 0; k < fields; ++k) lines.insert(lines.end(), {from + pitch * k, from + pitch * k + 0.9});
  lines.push_back(to);
  return lines;
}

void add_paving(GlbWriter& glb, const Rect& lot) {
  const std::vector<double> x = paving_lines(lot.x0, lot.x1);
  const std::vector<double> y = paving_lines(lot.y0, lot.y1);
  MeshBuilder mesh("ground_plaza");
  for (std::size_t i = 0; i + 1 < x.size(); ++i) {
    for (std::size_t j = 0; j + 1 < y.size(); ++j) {
      const bool band = i % 2 == 0 || j % 2 == 0;
      mesh.cap(Rect{x[i], y[j], x[i + 1], y[j + 1]}.polygon(), kKerb, band ? Mat::kStoneLight : Mat::kStonePolished);
    }
  }
  glb.add(mesh);
}

void add_basin(MeshBuilder& mesh, Vec3 at, double radius, double height, double rim, double water, int sides) {
  const Polygon outer = circle({0, 0}, radius, sides);
  const Polygon inner = circle({0, 0}, radius - rim, sides);
  mesh.set_frame(at);
  mesh.walls(outer, 0, height, Mat::kMonumentStone);
  for (std::size_t i = 0; i < outer.size(); ++i) {
    const std::size_t k = (i + 1) % outer.size();
    mesh.quad({outer[i], height}, {outer[k], height}, {inner[k], height}, {inner[i], height}, Mat::kMonumentStone);
  }
  mesh.walls(inner, water, height, Mat::kMonumentStone, false);
  mesh.cap(inner, water, Mat::kWater);
  mesh.cap(outer, 0, Mat::kMonumentStone, false);
  mesh.set_frame({0, 0, 0});
}

void add_fountain(GlbWriter& glb, Vec2 c) {
  MeshBuilder mesh("fountain");
  const double base = kKerb - 0.05;
  add_basin(mesh, {c, base}, 5.5, 0.75, 0.45, 0.5, 28);
  mesh.tube({c, base + 0.4}, {c, base + 2.1}, 0.55, 0.35, 12, Mat::kMonumentStone);
  mesh.tube({c, base + 1.95}, {c, base + 2.4}, 0.4, 1.7, 16, Mat::kMonumentStone);
  add_basin(mesh, {c, base + 2.39}, 1.75, 0.25, 0.2, 0.18, 16);
  mesh.tube({c, base + 2.5}, {c, base + 3.4}, 0.25, 0.18, 10, Mat::kMonumentStone);
  mesh.tube({c, base + 3.35}, {c, base + 3.6}, 0.2, 0.7, 12, Mat::kMonumentStone);
  add_basin(mesh, {c, base + 3.59}, 0.72, 0.15, 0.1, 0.1, 12);
  glb.add(mesh);
}

void add_obelisk(GlbWriter& glb, Vec2 c) {
  MeshBuilder mesh("obelisk");
  double z = kKerb - 0.05;
  for (int step = 0; step < 3; ++step) {
    const double half = 4 - 0.7 * step;
    mesh.box({c.x - half, c.y - half, z}, {c.x + half, c.y + half, z + 0.35}, Mat::kMonumentStone);
    z += 0.34;
  }
  mesh.box({c.x - 1.5, c.y - 1.5, z}, {c.x + 1.5, c.y + 1.5, z + 2.6}, Mat::kStonePolished, Mat::kMonumentStone);
  z += 2.59;
  const double low = 1.0, high = 0.62, top = z + 13;
  const auto ring = [&](double half, double height, int k) {
    const double sx[] = {-1, 1, 1, -1}, sy[] = {-1, -1, 1, 1};
    return Vec3{c.x + sx[k % 4] * half, c.y + sy[k % 4] * half, height};
  };
  for (int k = 0; k < 4; ++k) {
    mesh.quad(ring(low, z, k), ring(low, z, k + 1), ring(high, top, k + 1), ring(high, top, k), Mat::kMonumentStone);
    mesh.triangle(ring(high, top, k), ring(high, top, k + 1), {c, top + 1.3}, Mat::kPaintYellow);
  }
  mesh.quad(ring(low, z, 0), ring(low, z, 3), ring(low, z, 2), ring(low, z, 1), Mat::kMonumentStone);
  glb.add(mesh);
}

}  // namespace

void add_plaza(GlbWriter& glb, const Layout& layout, std::span<const Shot> shots) {
  const Rect lot = layout.lot(layout.core, layout.core + 1);
  const Vec2 c = lot.center();
  Rng rng(layout.seed, 0x706C617A, 0, 0);
  add_paving(glb, lot);
  add_fountain(glb, c);
  add_obelisk(glb, c + Vec2{0, 23});
  int count = 0;
  const auto add = [&](const char* kind, Vec2 at, double radius, const auto& make) {
    if (blocks_view(shots, at, radius)) return;
    MeshBuilder mesh(std::string("plaza_") + kind + "_" + std::to_string(count++));
    make(mesh);
    glb.add(mesh);
  };
  // Two rows of trees on the west and east sides, each in a low round bed.
  for (const double x : {lot.x0 + 6, lot.x0 + 14, lot.x1 - 14, lot.x1 - 6}) {
    for (double y = lot.y0 + 10; y < lot.y1 - 6; y += 9) {
      add("tree", {x, y}, 2.5, [&](MeshBuilder& m) {
        m.prism(circle({x, y}, 0.9, 10), kKerb - 0.05, kKerb + 0.4, Mat::kMonumentStone, Mat::kSoil);
        add_tree(m, rng, {x, y, kKerb + 0.4}, rng.range(6.5, 9));
      });
    }
  }
  static constexpr int kBenches = 8;
  for (int k = 0; k < kBenches; ++k) {
    const Vec2 out = circle({0, 0}, 1, kBenches, 0.3927)[static_cast<std::size_t>(k)];
    const Vec2 at = c + out * 10.5;
    add("bench", at, 0.8, [&](MeshBuilder& m) { add_bench(m, {{at, kKerb}, -out}); });
  }
  for (double x = lot.x0 + 1; x <= lot.x1 - 1; x += 2.5) {
    for (const double y : {lot.y0 + 0.4, lot.y1 - 0.4}) {
      add("bollard", {x, y}, 0.1, [&](MeshBuilder& m) { add_bollard(m, {x, y, kKerb}); });
    }
  }
  for (const double sx : {-1.0, 1.0}) {
    for (const double sy : {-1.0, 1.0}) {
      const Vec2 at = c + Vec2{sx * 17, sy * 16};
      add("lamp", at, 0.8, [&](MeshBuilder& m) { add_lamp(m, {{at, kKerb}, {-sx, 0}}); });
    }
  }
}

}  // namespace zc::generate
