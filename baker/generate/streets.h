// SPDX-License-Identifier: GPL-3.0-or-later
// The ground: roads, crossings, sidewalks with kerbs, the skirt around the city. Markings, puddles and manholes are cut
// into the road's surface, so nothing lies on top of anything.
// Units: metres. Thread-safe: one writer per thread.
#pragma once

#include <span>

#include "baker/generate/drive.h"
#include "baker/generate/glb_writer.h"
#include "baker/generate/layout.h"
#include "baker/generate/rng.h"

namespace zc::generate {

// A straight piece of road between two crossings: local x runs along it from 0 to length, y across.
struct Segment {
  Vec3 origin = {0, 0, 0};
  Vec2 heading = {1, 0};
  double length = 0;
  double width = 0;
  bool east = true;  // runs east on y line `line`, else north on x line `line`
  int line = 0;
  int step = 0;             // between crossings step and step + 1
  bool block_right = true;  // a block lies on the side of local -y / +y
  bool block_left = true;
};
Segment make_segment(const Layout& layout, bool east, int line, int step);
// The street that climbs the bridge.
bool is_ramp(const Layout& layout, const Segment& segment);

void add_road_surface(MeshBuilder& mesh, Rng& rng, double x0, double x1, double width, bool full);
void add_road(GlbWriter& glb, const Layout& layout, const Segment& segment);
void add_crossing(GlbWriter& glb, const Layout& layout, int i, int j);
void add_sidewalk(GlbWriter& glb, const Layout& layout, int i, int j);
void add_skirt(GlbWriter& glb, const Layout& layout);
// Lamps, trees, cars, bus stops along a segment, and lights at a crossing; nothing that would stand in a shot's view.
void add_street_furniture(GlbWriter& glb, const Layout& layout, const Segment& segment, std::span<const Shot> shots);
void add_traffic_lights(GlbWriter& glb, const Layout& layout, int i, int j, std::span<const Shot> shots);

}  // namespace zc::generate
