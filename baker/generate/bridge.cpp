// SPDX-License-Identifier: GPL-3.0-or-later
// The bridge on x line core+2: two ramps between retaining walls, a deck on piers, and a street underneath.
#include <cmath>
#include <string>

#include "baker/generate/landmarks.h"
#include "baker/generate/streets.h"

namespace zc::generate {
namespace {

constexpr double kGutter = 0.6;    // level strip between ramp and kerb
constexpr double kParapet = 0.25;  // thickness
constexpr double kParapetHigh = 0.9;
constexpr double kDeckThick = 0.9;
constexpr double kLineHalf = 0.075;

// Height of the road, x metres from the underpass street's centre, on a ramp that ends at `end`.
double ramp_height(double x, double end) {
  const double t = (x - kUnderpassReach) / (end - kUnderpassReach);
  return kDeckTop * (1 - t * t * (3 - 2 * t));
}

// Local x runs away from the bridge.
void add_ramp(MeshBuilder& mesh, double end, double width) {
  const double hw = width / 2 - kGutter;
  const double in = hw - kParapet;
  const int steps = static_cast<int>(std::ceil((end - kUnderpassReach) / 5));
  const double ys[] = {-in, -kLineHalf, kLineHalf, in};
  for (int k = 0; k < steps; ++k) {
    const double x0 = kUnderpassReach + (end - kUnderpassReach) * k / steps;
    const double x1 = kUnderpassReach + (end - kUnderpassReach) * (k + 1) / steps;
    const double z0 = ramp_height(x0, end), z1 = k + 1 == steps ? 0 : ramp_height(x1, end);
    const double p0 = z0 + kParapetHigh, p1 = z1 + kParapetHigh;
    for (int c = 0; c < 3; ++c) {
      mesh.quad({x0, ys[c], z0}, {x1, ys[c], z1}, {x1, ys[c + 1], z1}, {x0, ys[c + 1], z0},
                c == 1 ? Mat::kLaneWhite : Mat::kAsphaltWet);
    }
    mesh.quad({x0, in, z0}, {x1, in, z1}, {x1, in, p1}, {x0, in, p0}, Mat::kConcreteGrey);
    mesh.quad({x1, -in, z1}, {x0, -in, z0}, {x0, -in, p0}, {x1, -in, p1}, Mat::kConcreteGrey);
    mesh.quad({x0, in, p0}, {x1, in, p1}, {x1, hw, p1}, {x0, hw, p0}, Mat::kKerbStone);
    mesh.quad({x0, -hw, p0}, {x1, -hw, p1}, {x1, -in, p1}, {x0, -in, p0}, Mat::kKerbStone);
    mesh.quad({x1, hw, 0}, {x0, hw, 0}, {x0, hw, p0}, {x1, hw, p1}, Mat::kConcreteGrey);
    mesh.quad({x0, -hw, 0}, {x1, -hw, 0}, {x1, -hw, p1}, {x0, -hw, p0}, Mat::kConcreteGrey);
    const double h = width / 2;
    mesh.quad({x0, hw, 0}, {x1, hw, 0}, {x1, h, 0}, {x0, h, 0}, Mat::kAsphaltWet);
    mesh.quad({x0, -h, 0}, {x1, -h, 0}, {x1, -hw, 0}, {x0, -hw, 0}, Mat::kAsphaltWet);
  }
  const double a = kUnderpassReach;
  for (const double y : {-hw, in}) {
    mesh.quad({end, y, 0}, {end, y + kParapet, 0}, {end, y + kParapet, kParapetHigh}, {end, y, kParapetHigh},
              Mat::kConcreteGrey);
    mesh.quad({a, y + kParapet, kDeckTop}, {a, y, kDeckTop}, {a, y, kDeckTop + kParapetHigh},
              {a, y + kParapet, kDeckTop + kParapetHigh}, Mat::kConcreteGrey);
  }
  const double under = kDeckTop - kDeckThick;
  mesh.quad({a, hw, 0}, {a, -hw, 0}, {a, -hw, under}, {a, hw, under}, Mat::kConcreteGrey);
}

void add_deck(MeshBuilder& mesh, double width) {
  const double hw = width / 2 - kGutter;
  const double in = hw - kParapet;
  const double x0 = -kUnderpassReach, x1 = kUnderpassReach;
  const double top = kDeckTop, under = kDeckTop - kDeckThick, edge = kDeckTop + 0.15;
  const double ys[] = {-in, -kLineHalf, kLineHalf, in};
  for (int c = 0; c < 3; ++c) {
    mesh.quad({x0, ys[c], top}, {x1, ys[c], top}, {x1, ys[c + 1], top}, {x0, ys[c + 1], top},
              c == 1 ? Mat::kLaneWhite : Mat::kAsphaltWet);
  }
  mesh.quad({x0, in, top}, {x1, in, top}, {x1, in, edge}, {x0, in, edge}, Mat::kKerbStone);
  mesh.quad({x1, -in, top}, {x0, -in, top}, {x0, -in, edge}, {x1, -in, edge}, Mat::kKerbStone);
  mesh.quad({x0, in, edge}, {x1, in, edge}, {x1, hw, edge}, {x0, hw, edge}, Mat::kKerbStone);
  mesh.quad({x0, -hw, edge}, {x1, -hw, edge}, {x1, -in, edge}, {x0, -in, edge}, Mat::kKerbStone);
  mesh.quad({x1, hw, under}, {x0, hw, under}, {x0, hw, edge}, {x1, hw, edge}, Mat::kConcreteGrey);
  mesh.quad({x0, -hw, under}, {x1, -hw, under}, {x1, -hw, edge}, {x0, -hw, edge}, Mat::kConcreteGrey);
  mesh.quad({x0, hw, under}, {x1, hw, under}, {x1, -hw, under}, {x0, -hw, under}, Mat::kConcreteGrey);
}

}  // namespace

void add_bridge(GlbWriter& glb, const Layout& layout) {
  const auto i = static_cast<std::size_t>(layout.core) + 2;
  const auto j = static_cast<std::size_t>(layout.core) + 1;
  const Line& over = layout.x[i];
  const Line& beneath = layout.y[j];
  const Vec3 center = {over.at, beneath.at, 0};
  const double hw = over.width / 2 - kGutter;
  const double h = over.width / 2;

  MeshBuilder north("bridge_ramp_north");
  north.set_frame(center, {0, 1});
  add_ramp(north, layout.y[j + 1].low() - kCornerRadius - beneath.at, over.width);
  glb.add(north);
  MeshBuilder south("bridge_ramp_south");
  south.set_frame(center, {0, -1});
  add_ramp(south, beneath.at - layout.y[j - 1].high() - kCornerRadius, over.width);
  glb.add(south);

  MeshBuilder deck("bridge_deck");
  deck.set_frame(center, {0, 1});
  add_deck(deck, over.width);
  glb.add(deck);

  const double under = kDeckTop - kDeckThick;
  MeshBuilder frame("bridge_piers");
  frame.set_frame(center, {0, 1});
  for (const double y : {-0.62 * hw, 0.0, 0.62 * hw}) {
    frame.box({-kUnderpassReach + 0.05, y - 0.25, under - 0.4}, {kUnderpassReach - 0.05, y + 0.25, under + 0.05},
              Mat::kConcreteDark);
    for (const double side : {-1.0, 1.0}) {
      const double x = side * (beneath.width / 2 + 0.8);
      frame.tube({x, y, kKerb - 0.05}, {x, y, under - 0.35}, 0.32, 0.32, 12, Mat::kConcreteGrey);
    }
  }
  glb.add(frame);

  for (const double side : {-1.0, 1.0}) {
    MeshBuilder railing(side < 0 ? "bridge_railing_east" : "bridge_railing_west");
    railing.set_frame(center, {0, 1});
    const double y = side * (hw - kParapet / 2);
    const double top = kDeckTop + 1.15;
    for (int k = 0; k <= 12; ++k) {
      const double x = -kUnderpassReach + 0.15 + (2 * kUnderpassReach - 0.3) * k / 12;
      railing.tube({x, y, kDeckTop + 0.12}, {x, y, top}, 0.03, 0.03, 6, Mat::kMetalGalvanised);
    }
    for (const double z : {kDeckTop + 0.42, kDeckTop + 0.78, top}) {
      railing.tube({-kUnderpassReach, y, z}, {kUnderpassReach, y, z}, 0.035, 0.035, 6, Mat::kMetalGalvanised);
    }
    glb.add(railing);
  }

  MeshBuilder walk("sidewalk_underpass");
  walk.set_frame(center);
  for (const double side : {-1.0, 1.0}) {
    walk.set_frame(center, {side, 0});  // a half turn maps the north walk to the south one
    const double near = beneath.width / 2;
    const double far = kUnderpassReach;
    walk.quad({-h, near, 0}, {h, near, 0}, {h, near, kKerb}, {-h, near, kKerb}, Mat::kKerbStone);
    walk.quad({-h, near, kKerb}, {h, near, kKerb}, {h, near + 0.25, kKerb}, {-h, near + 0.25, kKerb}, Mat::kKerbStone);
    walk.quad({-h, near + 0.25, kKerb}, {h, near + 0.25, kKerb}, {h, far, kKerb}, {-h, far, kKerb},
              Mat::kConcreteSidewalk);
    walk.quad({-hw, far, 0}, {-h, far, 0}, {-h, far, kKerb}, {-hw, far, kKerb}, Mat::kKerbStone);
    walk.quad({h, far, 0}, {hw, far, 0}, {hw, far, kKerb}, {h, far, kKerb}, Mat::kKerbStone);
  }
  glb.add(walk);
}

}  // namespace zc::generate
