// SPDX-License-Identifier: GPL-3.0-or-later
// Which input it was: its size and a hash of its content. Of a folder all models in it count, with their paths below
// it; of a model that names other files, only its own. Thread-safe: no state. Fails when a file cannot be read.
#pragma once

#include <filesystem>

#include "baker/scene/bake_origin.h"
#include "base/result.h"

namespace zc {

Result<InputIdentity> identify_input(const std::filesystem::path& input);

}  // namespace zc
