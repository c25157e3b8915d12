// SPDX-License-Identifier: Apache-2.0
// The driver's own VK_KHR_ray_query over one bottom level with all triangles, built for fast tracing and compacted.
// Bytes are those of both acceleration structures; tracing reads nothing else. Borrows the device, which must have ray
// queries on. Threads: as the device.
#pragma once

#include <memory>

#include "replay/bench/engines/trace_engine.h"
#include "runtime/device/device.h"

namespace zc::bench {

std::unique_ptr<TraceEngine> make_ray_query_engine(Device& device, bool any_hit);

}  // namespace zc::bench
