// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/generate/drive.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "baker/generate/landmarks.h"

namespace zc::generate {
namespace {

constexpr double kRate = 30;      // samples per second
constexpr double kSpeed = 14;     // m/s on the straight
constexpr double kTurnSpeed = 6;  // m/s in corners
constexpr double kBraking = 3;    // m/s^2
constexpr double kLane = 1.6;     // right of the street's centre
constexpr double kTurnRadius = 7;
constexpr double kEyeHeight = 1.4;
constexpr double kLookAhead = 8;
constexpr double kLookDown = 0.5;
constexpr double kFov = 60;
constexpr double kTurn = 6.283185307179586;

// A closed loop of four straights and four left turns.
class Loop {
 public:
  explicit Loop(const Rect& r) {
    const double e = kTurnRadius;
    const std::array<Vec2, 4> from = {Vec2{r.x0 + e, r.y0}, {r.x1, r.y0 + e}, {r.x1 - e, r.y1}, {r.x0, r.y1 - e}};
    static constexpr double kDirX[] = {1, 0, -1, 0}, kDirY[] = {0, 1, 0, -1};
    for (std::size_t k = 0; k < 4; ++k) {
      const double straight = (k % 2 == 0 ? r.width() : r.height()) - 2 * e;
      legs_[k] = {from[k], {kDirX[k], kDirY[k]}, straight, length_};
      length_ += straight + kTurn / 4 * e;
    }
  }

  [[nodiscard]] double length() const { return length_; }

  [[nodiscard]] Vec2 at(double s) const {
    s = std::fmod(s, length_);
    const Leg& leg = leg_at(s);
    const double along = s - leg.start;
    if (along <= leg.straight) return leg.from + leg.dir * along;
    const double angle = (along - leg.straight) / kTurnRadius;
    const Vec2 left = {-leg.dir.y, leg.dir.x};
    const Vec2 center = leg.from + leg.dir * leg.straight + left * kTurnRadius;
    return center + kTurnRadius * (leg.dir * std::sin(angle) - left * std::cos(angle));
  }

  // The speed that can still brake for the next corner and has sped up since the last.
  [[nodiscard]] double speed(double s) const {
    s = std::fmod(s, length_);
    const Leg& leg = leg_at(s);
    const double along = s - leg.start;
    const double to_corner = std::max(0.0, std::min(along, leg.straight - along));
    return std::min(kSpeed, std::sqrt(kTurnSpeed * kTurnSpeed + 2 * kBraking * to_corner));
  }

 private:
  struct Leg {
    Vec2 from, dir;
    double straight = 0;
    double start = 0;
  };
  [[nodiscard]] const Leg& leg_at(double s) const {
    std::size_t k = 3;
    while (k > 0 && legs_[k].start > s) --k;
    return legs_[k];
  }
  std::array<Leg, 4> legs_;
  double length_ = 0;
};

}  // namespace

std::vector<Shot> make_shots(const Layout& layout) {
  const auto c = static_cast<std::size_t>(layout.core);
  const double y1 = layout.y[c + 1].at, y2 = layout.y[c + 2].at;
  const double bridge_x = layout.x[c + 2].at;
  const double x3 = layout.x[c + 3].at;
  const Rect tires = tire_shop_rect(layout);
  const Rect hall = warehouse_rect(layout);
  const Rect mirror = mirror_rect(layout);
  const Vec2 plaza = layout.lot(layout.core, layout.core + 1).center();
  return {
      {"tire_shop", {tires.center().x - 13, y1 + 1.2, 1.6}, {tires.center().x + 1, tires.y1, 1.7}, 60},
      {"underpass", {bridge_x - 17, y1 + 1.4, 1.5}, {bridge_x + 14, y1 - 1.2, 1.3}, 60},
      {"warehouse", {x3 + 1.5, hall.center().y - 22, 1.6}, {hall.x1, hall.center().y - 1, 2.4}, 60},
      {"mirror_window", {mirror.center().x + 17, y2 - 1.6, 1.6}, {mirror.center().x - 1, mirror.y0, 4.6}, 60},
      {"plaza", {plaza.x - 7, plaza.y - 27, 1.75}, {plaza.x + 1.5, plaza.y + 8, 2.9}, 60},
      {"bridge", {bridge_x - 40, y1 - 1.4, 1.6}, {bridge_x, y1 + 0.8, 2.6}, 60},
  };
}

bool blocks_view(std::span<const Shot> shots, Vec2 place, double radius_m) {
  return std::any_of(shots.begin(), shots.end(), [&](const Shot& shot) {
    const Vec2 eye{shot.eye};
    const Vec2 target{shot.target};
    if (glm::distance(place, eye) < radius_m + 3) return true;
    // The middle of the view, up to the target.
    const double length = glm::distance(eye, target);
    const Vec2 ahead = (target - eye) / length;
    const double along = glm::dot(place - eye, ahead);
    const double aside = std::abs(ahead.x * (place.y - eye.y) - ahead.y * (place.x - eye.x));
    return along > 0 && along < length && aside < radius_m + 0.4 + 0.45 * along;
  });
}

std::vector<DriveSample> make_drive(const Layout& layout) {
  const auto c = static_cast<std::size_t>(layout.core);
  const Loop loop(
      {layout.x[c].at - kLane, layout.y[c + 1].at - kLane, layout.x[c + 3].at + kLane, layout.y[c + 2].at + kLane});
  std::vector<DriveSample> drive;
  double s = 0;
  while (s < loop.length()) {
    const double time_s = static_cast<double>(drive.size()) / kRate;
    drive.push_back({time_s, {loop.at(s), kEyeHeight}, {loop.at(s + kLookAhead), kEyeHeight - kLookDown}});
    s += loop.speed(s) / kRate;
  }
  return drive;
}

std::string drive_csv(std::span<const DriveSample> drive) {
  std::string out = "time_s,eye_x,eye_y,eye_z,target_x,target_y,target_z,fov_y_deg\n";
  for (const DriveSample& d : drive) {
    std::array<char, 256> line{};
    const int n = std::snprintf(line.data(), line.size(), "%.6f,%.4f,%.4f,%.4f,%.4f,%.4f,%.4f,%.1f\n", d.time_s,
                                d.eye.x, d.eye.y, d.eye.z, d.target.x, d.target.y, d.target.z, kFov);
    out.append(line.data(), static_cast<std::size_t>(n));
  }
  return out;
}

std::string shots_json(std::span<const Shot> shots) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Shot& s : shots) {
    list.push_back({{"name", s.name},
                    {"eye", {s.eye.x, s.eye.y, s.eye.z}},
                    {"target", {s.target.x, s.target.y, s.target.z}},
                    {"fov_y_deg", s.fov_y_deg}});
  }
  return nlohmann::ordered_json{{"shots", list}}.dump(1) + "\n";
}

}  // namespace zc::generate
