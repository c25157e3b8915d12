// SPDX-License-Identifier: Apache-2.0
// A world's index, wherever the world comes from. Thread-safe: no state.
#pragma once

#include <filesystem>

#include "streamer/source/source.h"
#include "streamer/world_format/world_index.h"

namespace zc {

// `place`: of the world, for errors. Fails when the index is larger than limit_bytes.
Result<WorldIndex> read_world_index(Source& source, const std::filesystem::path& place = {},
                                    std::uint64_t limit_bytes = 1ULL << 32U);

}  // namespace zc
