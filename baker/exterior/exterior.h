// SPDX-License-Identifier: GPL-3.0-or-later
// Drops the faces that nobody outside can see: both of whose sides face spaces that are sealed off, as the rooms
// of closed buildings, what stands in them, and the walls between buildings that touch.
//
// What a free line of sight joins is one space. Rays from many points of a face's sides show which sides face the same
// space, and which the open: a ray that hits nothing, in whatever direction, has left. A face stays when either
// of its sides faces the open or a space that any other side shows to be open, through a window, a gap or a
// missing floor; so whatever is seen from the sky, from a street or from below stays, as far as rays a quarter of a
// metre apart find the openings. Ground stays always.
//
// Deterministic at any thread count. Fails when Embree does.
#pragma once

#include <cstdint>

#include "baker/repair/snap.h"
#include "base/result.h"

namespace zc {

struct ExteriorScene {
  SnappedScene scene;
  std::uint64_t dropped = 0;  // faces; objects without a face are gone too
};

// Needs the whole city: rays go as far as it does. A world too wide for rays in single precision stays whole, with a
// note.
Result<ExteriorScene> drop_interior(SnappedScene&& scene, BakeContext& context);

}  // namespace zc
