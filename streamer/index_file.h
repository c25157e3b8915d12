// SPDX-License-Identifier: Apache-2.0
// A world's index, wherever the world comes from. Thread-safe: no state.
#pragma once

#include <filesystem>

#include "streamer/source.h"
#include "streamer/world_format/world_index.h"

namespace zc {

// `place`: of the world, for errors.
Result<WorldIndex> read_world_index(Source& source, const std::filesystem::path& place = {});

}  // namespace zc
