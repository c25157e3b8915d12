// SPDX-License-Identifier: GPL-3.0-or-later
// Objects far from the mass of the others: a wrong reference system, a vertex with a digit too many, two cities in one
// bake. They make a world wide, and everything in it coarse. Thread-safe: no state.
#pragma once

#include <string>
#include <vector>

#include "baker/scene/scene.h"

namespace zc {

// One line for those that lie far away and one for those that reach there, with the first of their names; none: no
// line.
std::vector<std::string> describe_stray_objects(const Scene& scene);

}  // namespace zc
