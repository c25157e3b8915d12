// SPDX-License-Identifier: GPL-3.0-or-later
// What stands on an ordinary block: rows of houses around a yard, detached buildings, a tower, or a park.
// Units: metres. Thread-safe: one writer per thread.
#pragma once

#include "baker/generate/glb_writer.h"
#include "baker/generate/layout.h"

namespace zc::generate {

// Buildings get names building_<i>_<j>_<k>; the counter goes on where it stands.
struct BlockSite {
  int i = 0, j = 0;
  int next = 0;
};

void add_town_block(GlbWriter& glb, const Layout& layout, int i, int j);
void add_park_block(GlbWriter& glb, const Layout& layout, int i, int j);

// A row of adjoining houses that fronts the side of `strip` that `front` names (0 south, 1 east, 2 north, 3 west).
struct RowStyle {
  double height_low_m = 10, height_high_m = 16;
  double width_low_m = 11, width_high_m = 20;
  bool colourful = false;  // narrow gabled houses, each of another colour
  bool ends_open = true;   // the first and last house have windows on their outer sides
};
void add_house_row(GlbWriter& glb, const Layout& layout, BlockSite& site, const Rect& strip, int front,
                   const RowStyle& style);

// Cuts the rectangle into detached buildings with gaps between.
void add_detached(GlbWriter& glb, const Layout& layout, BlockSite& site, const Rect& lot, double height_m);

}  // namespace zc::generate
