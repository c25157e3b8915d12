// SPDX-License-Identifier: Apache-2.0
// The cut through the tree that is shown: resident nodes that together cover the whole world exactly once. A node gives
// way to its children when every child is resident or covered below itself, so a page that cannot be read costs detail
// and never a hole. Threads: one.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "streamer/world_format/world_index.h"

namespace zc {

// The deepest such cut, sorted by id, into `cover`. `resident`: per node; the root must be resident. `scratch`: per
// node.
void compute_cover(const WorldIndex& index, std::span<const std::uint8_t> resident, std::span<std::uint8_t> scratch,
                   std::vector<std::uint32_t>& cover);

}  // namespace zc
