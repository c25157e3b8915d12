// SPDX-License-Identifier: Apache-2.0
// The colour of what the queued rays hit.
#include <cstddef>

#include "runtime/passes/pass.h"

namespace zc::passes {

extern const Pass shade_hits;
const Pass shade_hits = {
    .key = "shade",
    .left_out = unless_mirrors,
    .record = [](PassRecorder& r) { r.dispatch_indirect(offsetof(gpu::Counters, trace_groups_x)); },
};

}  // namespace zc::passes
