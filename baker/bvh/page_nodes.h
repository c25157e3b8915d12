// SPDX-License-Identifier: GPL-3.0-or-later
// Lays a wide tree out as the `.zbvh` of a zone: quantised nodes, and clusters of what a depth-first visit finds in
// turn, so that neighbours share vertices. Deterministic. Thread-safe: no state.
#pragma once

#include "baker/bvh/collapse.h"
#include "base/result.h"
#include "streamer/world_format/bvh_page.h"

namespace zc {

// The tree and the appearance must be of this mesh. `record` gives the zone's origin and step.
BvhFile lay_out_bvh(const WideTree& tree, const ZoneMesh& mesh, ZoneAppearance appearance, const NodeRecord& record);

}  // namespace zc
