// SPDX-License-Identifier: Apache-2.0
// A world in one file, a .3tz as `zonecast pack` writes it. Holds one open file and no directory: each read finds its
// place in the archive's own index.
#pragma once

#include "streamer/source/source.h"

namespace zc {

// Fails when the file is no ZIP or has no usable index.
Result<std::unique_ptr<Source>> open_archive_source(const std::filesystem::path& file);

}  // namespace zc
