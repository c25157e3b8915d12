// SPDX-License-Identifier: Apache-2.0
// A zone of a bench's scene as a world would keep it. Deterministic. Thread-safe: no state.
#pragma once

#include "replay/bench/engines/trace_engine.h"
#include "streamer/world_format/bvh_page.h"

namespace zc::bench {

// The zone's triangles on its own 16-bit lattice, welded, in their order; the record says where that lies.
ZoneMesh weld_zone(const BenchScene& scene, const BenchZone& zone, NodeRecord& node);

}  // namespace zc::bench
