// SPDX-License-Identifier: Apache-2.0
// The pyramid of nearest depths that rays march through on the screen.
#include "runtime/passes/pass.h"

namespace zc::passes {

extern const Pass reduce_depth;
const Pass reduce_depth = {
    .key = "hiz",
    .left_out = [](const Features& f) { return f.screen ? unless_mirrors(f) : "not asked for"; },
    .record =
        [](PassRecorder& r) {
          for (std::uint32_t level = 0; level < r.frame.hiz_level_count; ++level) {
            const gpu::PassConstants constants{level, 0, 0, 0};
            r.dispatch(r.frame.hiz_levels[level].width, r.frame.hiz_levels[level].height, &constants);
          }
        },
};

}  // namespace zc::passes
