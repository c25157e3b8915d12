// SPDX-License-Identifier: GPL-3.0-or-later
// 3D Tiles 1.0 and 1.1 into the scene: what a viewer shows at full detail. Tilesets around the earth (EPSG:4978) are
// turned into a local frame, z up. Source: OGC 18-053r2 (1.0), OGC 22-025r4 (1.1). Untrusted input.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "baker/import/shared/input_files.h"
#include "baker/import/shared/scene_builder.h"
#include "baker/import/shared/texture_images.h"
#include "base/result.h"

namespace zc {

// Where a tileset's files come from, and whether the import goes on without those that are not there.
struct TilesetSource {
  const InputFiles* files = &disk_files();
  bool skip_missing = false;
};

// `bytes` is the whole file at `path`: a tileset.json, or a tile's content by itself. Geocentric tilesets share the
// builder's local frame: they stay where they are to each other.
// Fails on required extensions that are not handled, on cycles and on files outside the folder of `path`.
Status import_tileset(std::vector<std::byte> bytes, const std::filesystem::path& path, const TilesetSource& source,
                      TextureImages& images, SceneBuilder& builder);

// A tileset in a ZIP archive (.3tz), whose files `source` has.
Status import_tiles_archive(const std::filesystem::path& archive, const TilesetSource& source, TextureImages& images,
                            SceneBuilder& builder);

// A tileset, or a tile's content, on a web server.
Status import_web_tiles(const std::string& url, bool skip_missing, TextureImages& images, SceneBuilder& builder);

}  // namespace zc
