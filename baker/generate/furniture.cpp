// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/generate/furniture.h"

#include <array>

namespace zc::generate {
namespace {

constexpr double kSunk = 0.02;  // below the ground's surface, so that no light shows underneath

}  // namespace

void add_tree(MeshBuilder& mesh, Rng& rng, Vec3 at, double height_m, bool fine) {
  static constexpr Mat kLeaves[] = {Mat::kLeafDark,  Mat::kLeafDark,  Mat::kLeafDark,  Mat::kLeafLight,
                                    Mat::kLeafLight, Mat::kLeafLight, Mat::kLeafAutumn};
  mesh.set_frame(at);
  const double trunk = height_m * 0.42;
  mesh.tube({0, 0, -kSunk}, {0, 0, trunk}, 0.02 * height_m + 0.06, 0.012 * height_m + 0.04, fine ? 6 : 4,
            Mat::kTreeTrunk);
  std::array<double, 42> bumps{};
  for (double& b : bumps) b = rng.range(0.84, 1.12);
  const double r = height_m * rng.range(0.24, 0.3);
  mesh.blob({0, 0, height_m * 0.64}, {r, r, height_m * 0.33}, fine, bumps, rng.pick(kLeaves));
  mesh.set_frame({0, 0, 0});
}

void add_lamp(MeshBuilder& mesh, const Spot& spot) {
  mesh.set_frame(spot.at, spot.heading);
  mesh.tube({0, 0, -kSunk}, {0, 0, 7}, 0.09, 0.05, 6, Mat::kMetalDark);
  mesh.tube({-0.1, 0, 6.9}, {1.9, 0, 7.25}, 0.045, 0.035, 6, Mat::kMetalDark);
  mesh.box({1.35, -0.16, 7.06}, {2.15, 0.16, 7.12}, Mat::kLampGlass);
  mesh.box({1.3, -0.19, 7.115}, {2.2, 0.19, 7.3}, Mat::kMetalDark);
  mesh.set_frame({0, 0, 0});
}

void add_traffic_light(MeshBuilder& mesh, const Spot& spot) {
  mesh.set_frame(spot.at, spot.heading);
  mesh.tube({0, 0, -kSunk}, {0, 0, 3.5}, 0.07, 0.06, 6, Mat::kMetalDark);
  // A housing whose front is cut around the three lamps.
  const double y0 = -0.25, y1 = 0.06, x = 0.17, z0 = 2.5, z1 = 3.6;
  mesh.quad({x, y1, z0}, {-x, y1, z0}, {-x, y1, z1}, {x, y1, z1}, Mat::kMetalDark);
  mesh.quad({x, y0, z0}, {x, y1, z0}, {x, y1, z1}, {x, y0, z1}, Mat::kMetalDark);
  mesh.quad({-x, y1, z0}, {-x, y0, z0}, {-x, y0, z1}, {-x, y1, z1}, Mat::kMetalDark);
  mesh.quad({-x, y0, z1}, {x, y0, z1}, {x, y1, z1}, {-x, y1, z1}, Mat::kMetalDark);
  mesh.quad({-x, y1, z0}, {x, y1, z0}, {x, y0, z0}, {-x, y0, z0}, Mat::kMetalDark);
  static constexpr Mat kLamps[] = {Mat::kSignalGreen, Mat::kSignalAmber, Mat::kSignalRed};
  const double pitch = (z1 - z0) / 3;
  for (int k = 0; k < 3; ++k) {
    const double low = z0 + pitch * k;
    const double r = 0.12;
    const double c = low + pitch / 2;
    const std::array<Vec3, 4> cell = {Vec3{-x, y0, low}, {x, y0, low}, {x, y0, low + pitch}, {-x, y0, low + pitch}};
    const std::array<Vec3, 4> lamp = {Vec3{-r, y0, c - r}, {r, y0, c - r}, {r, y0, c + r}, {-r, y0, c + r}};
    for (std::size_t e = 0; e < 4; ++e)
      mesh.quad(cell[e], cell[(e + 1) % 4], lamp[(e + 1) % 4], lamp[e], Mat::kMetalDark);
    mesh.quad(lamp[0], lamp[1], lamp[2], lamp[3], kLamps[k]);
  }
  mesh.set_frame({0, 0, 0});
}

void add_bollard(MeshBuilder& mesh, Vec3 at) {
  mesh.tube(at + Vec3{0, 0, -kSunk}, at + Vec3{0, 0, 0.95}, 0.08, 0.07, 8, Mat::kMetalDark);
}

void add_bench(MeshBuilder& mesh, const Spot& spot) {
  mesh.set_frame(spot.at, spot.heading);
  for (const double y : {-0.75, 0.65}) mesh.box({-0.2, y, -kSunk}, {0.25, y + 0.1, 0.42}, Mat::kMetalDark);
  for (int k = 0; k < 3; ++k) mesh.box({-0.2 + 0.17 * k, -0.95, 0.415}, {-0.06 + 0.17 * k, 0.95, 0.47}, Mat::kDoorWood);
  for (int k = 0; k < 2; ++k) mesh.box({-0.28, -0.95, 0.6 + 0.18 * k}, {-0.23, 0.95, 0.72 + 0.18 * k}, Mat::kDoorWood);
  for (const double y : {-0.75, 0.65}) mesh.box({-0.24, y, 0.3}, {-0.19, y + 0.1, 0.88}, Mat::kMetalDark);
  mesh.set_frame({0, 0, 0});
}

void add_bin(MeshBuilder& mesh, Vec3 at) {
  mesh.tube(at + Vec3{0, 0, -kSunk}, at + Vec3{0, 0, 0.85}, 0.24, 0.28, 8, Mat::kMetalDark);
  mesh.tube(at + Vec3{0, 0, 0.84}, at + Vec3{0, 0, 0.98}, 0.29, 0.12, 8, Mat::kMetalGalvanised);
}

void add_bus_stop(MeshBuilder& mesh, const Spot& spot) {
  mesh.set_frame(spot.at, spot.heading);
  for (const double y : {-2.0, 2.0}) {
    for (const double x : {-0.65, 0.65}) mesh.tube({x, y, -kSunk}, {x, y, 2.45}, 0.04, 0.04, 6, Mat::kMetalGalvanised);
  }
  mesh.box({-0.85, -2.3, 2.43}, {0.95, 2.3, 2.53}, Mat::kMetalDark);
  mesh.box({-0.7, -1.93, 0.3}, {-0.66, 1.93, 2.3}, Mat::kGlassBlue);
  mesh.box({-0.55, -1.93, 0.3}, {0.6, -1.9, 2.3}, Mat::kPaintYellow);
  mesh.box({-0.55, -1.2, 0.44}, {-0.15, 1.2, 0.5}, Mat::kDoorWood);
  for (const double y : {-1.0, 1.0}) mesh.tube({-0.35, y, -kSunk}, {-0.35, y, 0.45}, 0.04, 0.04, 6, Mat::kMetalDark);
  mesh.set_frame({0, 0, 0});
}

void add_car(MeshBuilder& mesh, Rng& rng, const Spot& spot) {
  static constexpr Mat kPaints[] = {Mat::kPaintRed,   Mat::kPaintBlue,   Mat::kPaintWhite,  Mat::kPaintBlack,
                                    Mat::kPaintBlack, Mat::kPaintSilver, Mat::kPaintYellow, Mat::kPaintGreen};
  const Mat paint = rng.pick(kPaints);
  const double stretch = rng.range(0.93, 1.06);
  const bool estate = rng.chance(0.35);
  mesh.set_frame(spot.at, spot.heading);
  // The side view, counter-clockwise seen from the right: sill, bumper, bonnet, windscreen, roof, rear.
  struct Station {
    double x, z, half;
  };
  const double tail = estate ? -1.95 : -1.35;
  const std::array<Station, 12> side = {{{-2.1, 0.28, 0.86},
                                         {2.08, 0.28, 0.86},
                                         {2.2, 0.5, 0.84},
                                         {2.12, 0.72, 0.82},
                                         {1.05, 0.93, 0.82},
                                         {0.3, 1.42, 0.64},
                                         {tail + 0.5, 1.45, 0.64},
                                         {tail, 1.0, 0.8},
                                         {-2.1, 0.95, 0.8},
                                         {-2.22, 0.6, 0.83},
                                         {-2.2, 0.45, 0.85},
                                         {-2.15, 0.35, 0.86}}};
  const auto right = [&](std::size_t i) { return Vec3{side[i].x * stretch, -side[i].half, side[i].z}; };
  const auto left = [&](std::size_t i) { return Vec3{side[i].x * stretch, side[i].half, side[i].z}; };
  for (std::size_t i = 0; i < side.size(); ++i) {
    const std::size_t k = (i + 1) % side.size();
    const bool window = i == 4 || i == 6;
    mesh.quad(right(k), right(i), left(i), left(k), window ? Mat::kGlassDark : i == 0 ? Mat::kTyreRubber : paint);
  }
  // Each flank: body below the belt line 4 - 7, glass above.
  const std::array<std::array<std::size_t, 3>, 8> body = {
      {{0, 1, 11}, {1, 2, 11}, {2, 10, 11}, {2, 3, 10}, {3, 9, 10}, {3, 4, 9}, {4, 7, 9}, {7, 8, 9}}};
  for (const auto& [a, b, c] : body) {
    mesh.triangle(right(a), right(b), right(c), paint);
    mesh.triangle(left(a), left(c), left(b), paint);
  }
  mesh.quad(right(4), right(5), right(6), right(7), Mat::kGlassDark);
  mesh.quad(left(4), left(7), left(6), left(5), Mat::kGlassDark);
  for (const double x : {-1.35, 1.35}) {
    for (const double y : {-0.74, 0.74}) {
      mesh.tube({x * stretch, y - 0.13, 0.32}, {x * stretch, y + 0.13, 0.32}, 0.335, 0.335, 8, Mat::kTyreRubber);
    }
  }
  mesh.set_frame({0, 0, 0});
}

void add_tyre_stack(MeshBuilder& mesh, Rng& rng, Vec3 at, int count) {
  for (int k = 0; k < count; ++k) {
    const Vec3 center = at + Vec3{rng.range(-0.04, 0.04), rng.range(-0.04, 0.04), 0.1 + 0.21 * k};
    mesh.torus(center, {0, 0, 1}, 0.24, 0.11, 11, 5, Mat::kTyreRubber);
  }
}

}  // namespace zc::generate
