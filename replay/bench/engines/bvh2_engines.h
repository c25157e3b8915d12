// SPDX-License-Identifier: Apache-2.0
// Two compute kernels over one SAH tree of all triangles: the thesis's layout, visited without a stack
// (shaders/bench/trace_thesis.comp.glsl), and 64-byte nodes, nearer child first (trace_bvh2.comp.glsl).
// Borrow the device. Threads: as the device. Fail when the scene has more triangles than a reference numbers.
#pragma once

#include <memory>

#include "replay/bench/engines/trace_engine.h"
#include "runtime/device/device.h"

namespace zc::bench {

std::unique_ptr<TraceEngine> make_thesis_engine(Device& device, bool any_hit);
std::unique_ptr<TraceEngine> make_bvh2_engine(Device& device, bool any_hit);

}  // namespace zc::bench
