// SPDX-License-Identifier: GPL-3.0-or-later
// tileset.json of a world: 3D Tiles 1.1, explicit tiling, REPLACE refinement. Thread-safe: no state.
#pragma once

#include <string>

#include "streamer/world_format/world_index.h"

namespace zc {

std::string make_tileset_json(const WorldIndex& index);

}  // namespace zc
