// SPDX-License-Identifier: GPL-3.0-or-later
// The recorded drive and the still views, both derived from the layout alone.
// Units: metres, seconds, degrees; z up. Thread-safe: no state.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "baker/generate/layout.h"

namespace zc::generate {

struct Shot {
  std::string name;
  Vec3 eye;
  Vec3 target;
  double fov_y_deg = 60;
};

struct DriveSample {
  double time_s = 0;
  Vec3 eye;
  Vec3 target;
};

std::vector<Shot> make_shots(const Layout& layout);
// Whether something that wide at that place would stand before a shot's camera.
bool blocks_view(std::span<const Shot> shots, Vec2 place, double radius_m);

// Once around the core in the right-hand lane: past the plaza, through the underpass, past the tire shop, the warehouse
// and the mirror windows.
std::vector<DriveSample> make_drive(const Layout& layout);

std::string drive_csv(std::span<const DriveSample> drive);
std::string shots_json(std::span<const Shot> shots);

}  // namespace zc::generate
