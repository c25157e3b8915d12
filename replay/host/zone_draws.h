// SPDX-License-Identifier: Apache-2.0
// Which zones of a set a camera sees, as the stand-in engine draws them. Pure.
#pragma once

#include <vector>

#include "replay/host/stand_in_host.h"
#include "runtime/scene/zone_set.h"
#include "streamer/world_format/index_view.h"

namespace zc {

// Whether the node's box lies wholly on the outer side of one of the view's five planes.
bool outside_view(const FrameCamera& camera, double aspect, const NodeRecord& node);

// Zones that are shown and whose boxes touch the camera's view; all that are shown when `cull` is false.
std::vector<ZoneDraw> zone_draws(const ZoneSet& zones, const IndexView& index, const FrameCamera& camera, double aspect,
                                 bool cull);

}  // namespace zc
