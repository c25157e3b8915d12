// SPDX-License-Identifier: GPL-3.0-or-later
// 3D Tiles 1.0 and 1.1 into the scene: what a viewer shows at full detail. Tilesets around the earth (EPSG:4978) are
// turned into a local frame, z up. Source: OGC 18-053r2 (1.0), OGC 22-025r4 (1.1). Untrusted input.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "baker/import/shared/earth_frame.h"
#include "baker/import/shared/scene_builder.h"
#include "baker/import/shared/texture_images.h"
#include "base/result.h"

namespace zc {

// Whether JSON text is a tileset's; malformed text gives any answer.
bool is_tileset(std::string_view text);

// `text` is the whole file at `path`. The first geocentric tileset chooses `earth`, which all later ones share: they
// stay where they are to each other.
// Fails on implicit tiling, on required extensions that are not handled, on cycles and on files outside the folder of
// `path`.
Status import_tileset(std::string_view text, const std::string& path, std::optional<EarthFrame>& earth,
                      TextureImages& images, SceneBuilder& builder);

}  // namespace zc
