// SPDX-License-Identifier: Apache-2.0
// Turns the number of queued rays into the sizes of the dispatches over them.
#include "runtime/passes/pass.h"

namespace zc::passes {

extern const Pass size_dispatch;
const Pass size_dispatch = {
    .key = "compact",
    .left_out = unless_mirrors,
    .record = [](PassRecorder& r) { r.size_lists(); },
};

}  // namespace zc::passes
