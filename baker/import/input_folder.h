// SPDX-License-Identifier: GPL-3.0-or-later
// The models that a folder has in it. Thread-safe: no state.
#pragma once

#include <filesystem>
#include <vector>

#include "base/result.h"

namespace zc {

// In the order of their paths, of the folder and of all below it: archives, tilesets, and files that by their names may
// be models. A folder with a tileset.json is that tileset and nothing else; worlds below the folder, hidden folders and
// links to folders are passed over. Fails when a folder cannot be read.
Result<std::vector<std::filesystem::path>> models_in_folder(const std::filesystem::path& folder);

}  // namespace zc
