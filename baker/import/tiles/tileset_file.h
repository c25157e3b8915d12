// SPDX-License-Identifier: GPL-3.0-or-later
// One tileset.json, 3D Tiles 1.0 or 1.1, as a list of its tiles. Source: OGC 18-053r2 (1.0), OGC 22-025r4 (1.1),
// 3DTILES_implicit_tiling, 3DTILES_multiple_contents. Untrusted input. Thread-safe: plain values.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/mat4x4.hpp>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "baker/import/gltf/gltf_import.h"
#include "baker/import/tiles/tile_location.h"
#include "base/result.h"

namespace zc {

// Tiles that bits describe instead of one entry each.
struct ImplicitTiling {
  std::uint32_t branching = 4;  // children of a tile: 4 or 8
  std::uint32_t levels = 0;     // 0 to levels - 1 may have tiles
  std::uint32_t subtree_levels = 0;
  std::string subtrees;  // template of their URIs
};

struct Tile {
  std::size_t end = 0;  // index behind the last of the tiles below it, which come right after it
  bool adds = false;    // to its children (refine ADD), where others are replaced by them
  glm::dmat4 transform{1};
  TileVolume volume;
  std::vector<std::string> contents;  // URIs, or templates of them
  std::optional<ImplicitTiling> implicit;
};

struct TilesetFile {
  std::filesystem::path path;
  UpAxis up = UpAxis::kY;
  std::vector<Tile> tiles;  // the root first
  std::string crs;          // of a tileset that zonecast wrote, else empty
};

// Whether JSON text is a tileset's; malformed text gives any answer.
bool is_tileset(std::string_view text);

// Fails on required extensions that are not handled and on tiles that do not follow the format, named.
Result<TilesetFile> read_tileset(std::string_view text, const std::filesystem::path& path);

// The availability of contents and their URIs are lists in 3D Tiles 1.1, in an extension or single before: all of
// `single` and `several`, in order.
std::vector<const nlohmann::json*> all_of(const nlohmann::json& object, const char* single, const char* several);

}  // namespace zc
