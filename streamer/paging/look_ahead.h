// SPDX-License-Identifier: Apache-2.0
// Where a camera will be. Pure. Units: CRS metres, seconds.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "streamer/paging/selection.h"

namespace zc {

// For a live camera, whose path nobody knows: now, and `steps` views along its velocity, the last of them
// look_ahead_s from now. Appended to `views`.
void extrapolate_views(const glm::dvec3& eye, const glm::dvec3& velocity_m_per_s, double look_ahead_s,
                       std::uint32_t steps, std::vector<View>& views);

}  // namespace zc
