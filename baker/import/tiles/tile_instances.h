// SPDX-License-Identifier: GPL-3.0-or-later
// Where the instances of an i3dm stand: positions (plain, quantised), orientations (plain, as octahedra, east-north-up)
// and scales of its feature table. Source: OGC 22-025r4, section 10 (instanced 3D model). Untrusted input.
#pragma once

#include <glm/mat4x4.hpp>
#include <vector>

#include "baker/import/tiles/feature_table.h"

namespace zc {

// From the model once z is up to the tile. Fails when there are more than `limit`.
Result<std::vector<glm::dmat4>> read_instances(const FeatureTable& table, std::uint64_t limit);

}  // namespace zc
