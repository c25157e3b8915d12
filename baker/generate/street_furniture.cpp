// SPDX-License-Identifier: GPL-3.0-or-later
#include <string>

#include "baker/generate/furniture.h"
#include "baker/generate/streets.h"

namespace zc::generate {
namespace {

std::string place_name(const char* kind, const Segment& s, int k) {
  return std::string(kind) + (s.east ? "_e" : "_n") + std::to_string(s.line) + "_" + std::to_string(s.step) + "_" +
         std::to_string(k);
}

}  // namespace

void add_street_furniture(GlbWriter& glb, const Layout& layout, const Segment& s, std::span<const Shot> shots) {
  const Vec2 left = {-s.heading.y, s.heading.x};
  const auto at = [&](double x, double y) { return Vec2{s.origin} + s.heading * x + left * y; };
  const Detail detail = layout.detail(at(s.length / 2, 0));
  if (detail == Detail::kCoarse) return;
  Rng rng(layout.seed, s.east ? 0x66757265 : 0x6675726E, s.line, s.step);
  const bool ramp = is_ramp(layout, s);
  const bool trees = rng.chance(0.45);
  int count = 0;
  const auto add = [&](const char* kind, Vec2 place, double radius, const auto& make) {
    if (blocks_view(shots, place, radius)) return;
    MeshBuilder mesh(place_name(kind, s, count++));
    make(mesh);
    glb.add(mesh);
  };
  for (const double side : {-1.0, 1.0}) {
    if (side < 0 ? !s.block_right : !s.block_left) continue;
    const Vec2 to_road = left * -side;
    const double kerb = s.width / 2;
    // Opposite lamps stand staggered.
    for (double x = side < 0 ? 4 : 17; x < s.length - 3; x += detail == Detail::kFull ? 26 : 45) {
      const Vec2 p = at(x, side * (kerb + 0.6));
      add("lamp", p, 0.8, [&](MeshBuilder& m) { add_lamp(m, {{p, kKerb}, to_road}); });
      if (detail == Detail::kFull && rng.chance(0.3)) {
        const Vec2 q = at(x + 1.2, side * (kerb + 0.7));
        add("bin", q, 0.8, [&](MeshBuilder& m) { add_bin(m, {q, kKerb}); });
      }
    }
    if (trees) {
      const double pitch = detail == Detail::kFull ? 14 : 20;
      for (double x = 10.5; x < s.length - 4; x += pitch) {
        const Vec2 p = at(x, side * (kerb + 1));
        add("tree", p, 2.4, [&](MeshBuilder& m) {
          add_tree(m, rng, {p, kKerb}, rng.range(4.6, 6), detail == Detail::kFull);
        });
      }
    }
    if (ramp) continue;
    const bool stop = rng.chance(detail == Detail::kFull ? 0.14 : 0.03);
    if (stop) {
      const Vec2 p = at(s.length * 0.5, side * (kerb + 1.75));
      add("bus_stop", p, 2.5, [&](MeshBuilder& m) { add_bus_stop(m, {{p, kKerb}, to_road}); });
    }
    for (double x = rng.range(6, 12); x < s.length - 8; x += rng.range(5.6, 8)) {
      if (!rng.chance(detail == Detail::kFull ? 0.22 : 0.1) ||
          (stop && x > s.length * 0.5 - 10 && x < s.length * 0.5 + 10))
        continue;
      const Vec2 p = at(x, side * (kerb - 1.12));
      add("car", p, 2.6, [&](MeshBuilder& m) { add_car(m, rng, {{p, 0}, s.heading * -side}); });
    }
  }
}

void add_traffic_lights(GlbWriter& glb, const Layout& layout, int i, int j, std::span<const Shot> shots) {
  const Line& lx = layout.x[static_cast<std::size_t>(i)];
  const Line& ly = layout.y[static_cast<std::size_t>(j)];
  const Vec2 c = {lx.at, ly.at};
  if (layout.is_bridge(i, j) || layout.detail(c) != Detail::kFull) return;
  const bool has[] = {i<layout.n, j<layout.n, i> 0, j> 0};
  for (int d = 0; d < 4; ++d) {
    // Traffic that drives in direction d keeps right and stops before the crossing.
    static constexpr double kDirX[] = {1, 0, -1, 0}, kDirY[] = {0, 1, 0, -1};
    if (!has[(d + 2) % 4] || !has[(d + 3) % 4]) continue;
    const Vec2 dir = {kDirX[d], kDirY[d]};
    const Vec2 right = {dir.y, -dir.x};
    const double along = d % 2 == 0 ? lx.width : ly.width;
    const double across = d % 2 == 0 ? ly.width : lx.width;
    const Vec2 p = c - dir * (along / 2 + kCornerRadius + 0.5) + right * (across / 2 + 0.55);
    if (blocks_view(shots, p, 0.8)) continue;
    MeshBuilder mesh("traffic_light_" + std::to_string(i) + "_" + std::to_string(j) + "_" + std::to_string(d));
    add_traffic_light(mesh, {{p, kKerb}, right});
    glb.add(mesh);
  }
}

}  // namespace zc::generate
