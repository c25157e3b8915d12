// SPDX-License-Identifier: Apache-2.0
// The queued rays against the resident zones: in packets first, the others one by one.
#include "runtime/passes/pass.h"

namespace zc::passes {

extern const Pass trace_rays;
const Pass trace_rays = {
    .key = "trace",
    .left_out = unless_mirrors,
    .record = [](PassRecorder& r) { r.trace_queue(); },
};

}  // namespace zc::passes
