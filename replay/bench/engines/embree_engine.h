// SPDX-License-Identifier: Apache-2.0
// Embree 3 on the CPU, one ray at a time (rtcIntersect1): the fastest native tracer that a Debian package offers.
// Triangles are welded first, as Embree's manual advises; welding is not counted as build time, its buffers are counted
// as memory. Owns its buffers and Embree's device. Threads: one at a time; works on as many as it was made with.
#pragma once

#include <memory>

#include "replay/bench/engines/trace_engine.h"

namespace zc::bench {

// Whether Embree was found when this was built.
bool has_embree();

// robust: RTC_SCENE_FLAG_ROBUST. Null without Embree.
std::unique_ptr<TraceEngine> make_embree_engine(bool robust, bool any_hit, unsigned threads);

}  // namespace zc::bench
