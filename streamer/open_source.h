// SPDX-License-Identifier: Apache-2.0
// Opens a world wherever it is. Threads: any. Fails when the place is none of a world.
#pragma once

#include <filesystem>
#include <memory>

#include "streamer/source/source.h"

namespace zc {

// A directory, a .3tz archive (source/archive_source.h), or the address of one of them (source/http/http_source.h).
Result<std::unique_ptr<Source>> open_source(const std::filesystem::path& place, const SourceOptions& options = {});

}  // namespace zc
