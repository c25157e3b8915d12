// SPDX-License-Identifier: Apache-2.0
// A ray for each pixel that mirrors: through the depth buffer where that is asked for, the others into the ray queue.
#include <cstddef>

#include "runtime/passes/pass.h"

namespace zc::passes {

extern const Pass march_screen;
const Pass march_screen = {
    .key = "ssr",
    .left_out = unless_mirrors,
    .record = [](PassRecorder& r) { r.dispatch_indirect(offsetof(gpu::Counters, ssr_groups_x)); },
};

}  // namespace zc::passes
