// SPDX-License-Identifier: Apache-2.0
// The list of pixels that mirror; also clears what the frame before left in every pixel, so it is always needed.
#include "runtime/passes/pass.h"

namespace zc::passes {

extern const Pass classify_pixels;
const Pass classify_pixels = {
    .key = "classify",
    .left_out = [](const Features&) -> const char* { return nullptr; },
    .record =
        [](PassRecorder& r) {
          constexpr std::uint32_t tile = 8;
          if (r.features.thread_per_pixel)
            r.dispatch(r.frame.width, r.frame.height);
          else
            r.dispatch((r.frame.width + tile - 1) / tile, (r.frame.height + tile - 1) / tile);
          r.size_lists();
        },
};

}  // namespace zc::passes
