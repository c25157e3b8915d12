// SPDX-License-Identifier: Apache-2.0
#include "streamer/paging/look_ahead.h"

namespace zc {

void extrapolate_views(const glm::dvec3& eye, const glm::dvec3& velocity_m_per_s, double look_ahead_s,
                       std::uint32_t steps, std::vector<View>& views) {
  views.push_back({eye});
  for (std::uint32_t i = 1; i <= steps && look_ahead_s > 0; ++i)
    views.push_back({eye + velocity_m_per_s * (look_ahead_s * i / steps), i});
}

}  // namespace zc
