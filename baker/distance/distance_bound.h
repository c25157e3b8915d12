// SPDX-License-Identifier: GPL-3.0-or-later
// The largest distance from any point of a mesh to a surface, bounded from above: what samples miss, this does not.
// Units: steps. Thread-safe: no state. Deterministic at any thread count.
#pragma once

#include <span>

#include "baker/distance/measure.h"

namespace zc {

struct DistanceBound {
  double distance = 0;     // steps
  std::uint64_t work = 0;  // that it took
  bool is_loose = false;   // more work would have found less
};

// `known`: a distance that is reached, from samples; the bound is at least that, and close to the truth where the work
// that it may take per triangle allows. `promise`: a bound that is known to hold, or to be worth the work of
// confirming it; 0: none.
DistanceBound bound_distance(const LatticeMesh& from, std::span<const DetailSurface> to, double known, double promise);

}  // namespace zc
