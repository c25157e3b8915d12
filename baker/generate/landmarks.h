// SPDX-License-Identifier: GPL-3.0-or-later
// The places that the shots show, each on its own block of the core (see layout.h), and the bridge.
// Units: metres. Thread-safe: one writer per thread.
#pragma once

#include <span>

#include "baker/generate/drive.h"
#include "baker/generate/glb_writer.h"
#include "baker/generate/layout.h"

namespace zc::generate {

Rect tire_shop_rect(const Layout& layout);
Rect warehouse_rect(const Layout& layout);
Rect mirror_rect(const Layout& layout);

void add_plaza(GlbWriter& glb, const Layout& layout, std::span<const Shot> shots);
void add_tire_shop(GlbWriter& glb, const Layout& layout, std::span<const Shot> shots);
void add_warehouse(GlbWriter& glb, const Layout& layout);
void add_mirror_building(GlbWriter& glb, const Layout& layout);
void add_coloured_houses(GlbWriter& glb, const Layout& layout);
// Deck, ramps, abutments, piers, railings and the sidewalks of the underpass.
void add_bridge(GlbWriter& glb, const Layout& layout);

}  // namespace zc::generate
