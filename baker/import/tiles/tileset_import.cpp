// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/tiles/tileset_import.h"

#include <array>
#include <cstring>
#include <glm/gtc/matrix_transform.hpp>
#include <set>
#include <string_view>
#include <utility>

#include "baker/import/shared/gunzip.h"
#include "baker/import/shared/uri.h"
#include "baker/import/tiles/tile_content.h"
#include "baker/import/tiles/tile_files.h"
#include "baker/import/tiles/tile_walk.h"
#include "baker/import/tiles/tileset_file.h"
#include "baker/import/tiles/web_files.h"

namespace zc {
namespace {

constexpr std::uint64_t kMaxFileBytes = std::uint64_t{1} << 34U;

// In the world, each but once.
std::vector<glm::dmat4> world_places(const glm::dmat4& to_world, const std::vector<glm::dmat4>& in_tileset) {
  std::vector<glm::dmat4> places;
  std::set<std::array<double, 16>> known;
  for (const glm::dmat4& place : in_tileset) {
    std::array<double, 16> key{};
    std::memcpy(key.data(), &place, sizeof key);
    if (known.insert(key).second) places.push_back(to_world * place);
  }
  return places;
}

}  // namespace

Status import_tileset(std::vector<std::byte> bytes, const std::filesystem::path& path, const TilesetSource& source,
                      TextureImages& images, SceneBuilder& builder) {
  const std::filesystem::path file = normal_path(path);
  const std::filesystem::path root = folder_of(file);
  TileFiles files(*source.files, source.skip_missing);
  TileWalk walk(root, files);
  TileContents contents(root, files, images, builder);
  const auto to_world = [&](const std::optional<Geodetic>& origin) {
    if (!origin) return glm::dmat4(1);
    return builder.placement().earth(*origin).from_geocentric();
  };
  const auto crs_of = [&](const std::optional<Geodetic>& origin, const std::string& named) {
    return origin ? builder.placement().earth(*origin).crs() : named;
  };
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::size_t start = text.find_first_not_of(" \t\r\n");
  if (start == std::string_view::npos || text[start] != '{' || !is_tileset(text)) {
    TileLocation location;
    if (const auto center = center_of_content(bytes)) location.see(glm::translate(glm::dmat4(1), *center));
    const glm::dmat4 place = to_world(location.origin());
    ZC_TRY(builder.set_crs(crs_of(location.origin(), ""), path.string()));
    ZC_TRY(contents.add(std::move(bytes), file, UpAxis::kY, {place}));
  } else {
    ZC_ASSIGN(TilesetFile tileset, read_tileset(text, file));
    const std::string crs = tileset.crs;
    ZC_TRY(walk.run(std::move(tileset)));
    const glm::dmat4 turn = to_world(walk.origin());
    ZC_TRY(builder.set_crs(crs_of(walk.origin(), crs), path.string()));
    for (const PlacedContent& content : walk.contents()) {
      ZC_ASSIGN(std::optional<std::vector<std::byte>> tile, files.read(content.file, kMaxFileBytes));
      if (tile) ZC_TRY(contents.add(*std::move(tile), content.file, content.up, world_places(turn, content.places)));
    }
  }
  ZC_TRY(contents.finish());
  files.report(builder);
  return {};
}

Status import_tiles_archive(const std::filesystem::path& archive, const TilesetSource& source, TextureImages& images,
                            SceneBuilder& builder) {
  const std::filesystem::path path = normal_path(archive) / "tileset.json";
  ZC_ASSIGN(std::vector<std::byte> bytes, source.files->read(path, kMaxFileBytes));
  if (is_gzip(bytes)) {
    ZC_ASSIGN(bytes, gunzip(bytes, path.string(), kMaxUnpackedBytes));
  }
  return import_tileset(std::move(bytes), path, source, images, builder);
}

Status import_web_tiles(const std::string& url, bool skip_missing, TextureImages& images, SceneBuilder& builder) {
  ZC_ASSIGN(const WebTileset web, open_web_files(url));
  ZC_ASSIGN(std::vector<std::byte> bytes, web.files->read(web.path, kMaxFileBytes));
  if (is_gzip(bytes)) {
    ZC_ASSIGN(bytes, gunzip(bytes, web.path.string(), kMaxUnpackedBytes));
  }
  if (is_zip(bytes))
    return Error{ErrorCode::kUnsupported, "is an archive, expected a tileset.json; download it and bake the file",
                 web.path.string()};
  return import_tileset(std::move(bytes), web.path, {web.files.get(), skip_missing}, images, builder);
}

}  // namespace zc
