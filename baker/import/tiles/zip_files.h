// SPDX-License-Identifier: GPL-3.0-or-later
// The files in a .3tz, or any ZIP of a tileset: stored, deflated or compressed with Zstandard. minizip reads the
// directory of the ZIP.
// Owns the open archive. Untrusted input: sizes are checked against the archive and against what a file may unpack to.
// Not thread-safe.
#pragma once

#include <memory>

#include "baker/import/shared/input_files.h"

namespace zc {

// The archive is the folder of its files: in a.3tz the file tileset.json is a.3tz/tileset.json. Fails when it is
// damaged or has no tileset.json.
Result<std::unique_ptr<InputFiles>> open_zip_files(const std::filesystem::path& archive);

}  // namespace zc
