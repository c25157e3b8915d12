// SPDX-License-Identifier: Apache-2.0
// Which zones of a set a camera sees, as the stand-in engine draws them. Pure.
#pragma once

#include <vector>

#include "runtime/renderer.h"
#include "runtime/scene/zone_set.h"
#include "streamer/world_format/world_index.h"

namespace zc {

// Whether the node's box lies wholly on the outer side of one of the view's five planes.
bool outside_view(const RenderCamera& camera, double aspect, const NodeRecord& node);

// Zones that are shown and whose boxes touch the camera's view; all that are shown when `cull` is false.
std::vector<ZoneDraw> zone_draws(const ZoneSet& zones, const WorldIndex& index, const RenderCamera& camera,
                                 double aspect, bool cull);

}  // namespace zc
