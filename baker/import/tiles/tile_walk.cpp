// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/tiles/tile_walk.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "baker/import/shared/uri.h"

namespace zc {
namespace {

constexpr std::uint64_t kMaxTilesetBytes = std::uint64_t{1} << 30U;
constexpr std::uint64_t kMaxSubtreeBytes = std::uint64_t{1} << 26U;
constexpr std::size_t kMaxNesting = 32;
// Of an input as a whole, each as often as it is placed: a few tilesets that name each other twice make 2^32 tiles, and
// one bit of an implicit tiling millions.
constexpr std::size_t kMaxTiles = std::size_t{1} << 22U;
constexpr std::size_t kMaxContents = std::size_t{1} << 19U;
constexpr std::size_t kMaxExternals = std::size_t{1} << 18U;

std::string_view text_of(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

Error too_many(const TilesetFile& set, std::size_t limit, const char* what) {
  return {ErrorCode::kUnsupported,
          "has more than " + std::to_string(limit) + " " + what +
              ", each counted wherever it stands; bake a part of it: one of the tilesets that it names",
          set.path.string()};
}

}  // namespace

Status TileWalk::run(TilesetFile tileset) {
  const std::filesystem::path path = tileset.path;
  External& external = *externals_.emplace(path.string(), std::make_unique<External>()).first->second;
  external.tileset = std::move(tileset);
  ZC_TRY(walk_external(external, path, glm::dmat4(1)));
  if (!contents_.empty()) location_.see(contents_.front().places.front());
  return {};
}

// The same tileset at the same place shows what it showed there before.
Result<bool> TileWalk::walk_external(External& external, const std::filesystem::path& file,
                                     const glm::dmat4& transform) {
  if (!external.tileset) return false;
  Place place;
  std::memcpy(place.data(), &transform, sizeof place);
  static_assert(sizeof place == sizeof transform);
  if (external.is_open) return Error{ErrorCode::kFormat, "external tileset contains itself", file.string()};
  if (const auto known = external.shows.find(place); known != external.shows.end()) return known->second;
  if (++externals_placed_ > kMaxExternals) return too_many(*external.tileset, kMaxExternals, "external tilesets");
  if (nesting_ > kMaxNesting)
    return Error{ErrorCode::kUnsupported,
                 "external tilesets nest deeper than " + std::to_string(kMaxNesting) + " levels; bake it by itself",
                 file.string()};
  ++nesting_;
  external.is_open = true;
  ZC_ASSIGN(const bool shows, walk_tileset(*external.tileset, transform));
  external.is_open = false;
  --nesting_;
  external.shows.emplace(place, shows);
  return shows;
}

// Children before their parents, from the first to the last.
Result<bool> TileWalk::walk_tileset(const TilesetFile& set, const glm::dmat4& transform) {
  std::vector<OpenTile> open;
  bool shows = false;
  for (std::size_t next = 0; next < set.tiles.size() || !open.empty();) {
    if (open.empty() || next < set.tiles[open.back().index].end) {
      ZC_TRY(count_tile(set));
      open.push_back({next, (open.empty() ? transform : open.back().transform) * set.tiles[next].transform});
      if (Status seen = location_.see(set.tiles[next].volume, open.back().transform); !seen.ok())
        return Error{seen.error().code, seen.error().message, set.path.string()};
      ++next;
      continue;
    }
    OpenTile& closing = open.back();
    const Tile& tile = set.tiles[closing.index];
    if (tile.implicit) {
      ZC_ASSIGN(closing.shows, walk_subtree({set, tile, closing.transform}, {}));
    } else {
      ZC_ASSIGN(const bool own, walk_contents(set, tile.contents, closing.transform, !tile.adds && closing.shows));
      closing.shows = closing.shows || own;
    }
    shows = closing.shows;
    open.pop_back();
    if (!open.empty()) open.back().shows = open.back().shows || shows;
  }
  return shows;
}

Result<bool> TileWalk::walk_contents(const TilesetFile& set, const std::vector<std::string>& uris,
                                     const glm::dmat4& transform, bool is_replaced) {
  bool shows = false;
  for (const std::string& uri : uris) {
    ZC_ASSIGN(const std::filesystem::path file, file_of_uri(uri, set.path, root_));
    if (file.extension() == ".json") {
      // An external tileset is a child of its tile.
      ZC_ASSIGN(External* const external, external_at(file));
      if (!external->is_content) {
        ZC_ASSIGN(const bool external_shows, walk_external(*external, file, transform));
        shows = shows || external_shows;
        continue;
      }
    }
    if (is_replaced) continue;
    ZC_TRY(add(set, file, transform));
    shows = true;
  }
  return shows;
}

Result<TileWalk::External*> TileWalk::external_at(const std::filesystem::path& file) {
  const auto [slot, is_new] = externals_.try_emplace(file.string());
  if (!is_new) return slot->second.get();
  slot->second = std::make_unique<External>();
  ZC_ASSIGN(const std::optional<std::vector<std::byte>> bytes, files_.read(file, kMaxTilesetBytes));
  if (!bytes) return slot->second.get();
  if (is_tileset(text_of(*bytes))) {
    ZC_ASSIGN(slot->second->tileset, read_tileset(text_of(*bytes), file));
  } else {
    slot->second->is_content = true;
  }
  return slot->second.get();
}

// As deep as an implicit tiling has levels.
Result<bool> TileWalk::walk_subtree(const ImplicitWalk& walk, const TileAddress& top) {
  ZC_ASSIGN(const std::filesystem::path file,
            file_of_uri(fill_template(walk.root.implicit->subtrees, top), walk.set.path, root_));
  ZC_ASSIGN(const std::optional<std::vector<std::byte>> bytes, files_.read(file, kMaxSubtreeBytes));
  if (!bytes) return false;
  ZC_ASSIGN(const std::optional<Subtree> subtree, read_subtree(*bytes, file, root_, *walk.root.implicit, files_));
  if (!subtree) return false;
  return walk_implicit(walk, *subtree, top, 0, 0);
}

// `depth`, `morton`: of the tile in its subtree. Children before their parents, in Morton order.
Result<bool> TileWalk::walk_implicit(const ImplicitWalk& walk, const Subtree& subtree, const TileAddress& tile,
                                     std::uint32_t depth, std::uint64_t morton) {
  const ImplicitTiling& tiling = *walk.root.implicit;
  if (depth == tiling.subtree_levels) return subtree.child_subtrees.at(morton) ? walk_subtree(walk, tile) : false;
  std::uint64_t level_size = 1;
  for (std::uint32_t i = 0; i < depth; ++i) level_size *= tiling.branching;
  const std::uint64_t bit = (level_size - 1) / (tiling.branching - 1) + morton;
  if (!subtree.tiles.at(bit)) return false;
  ZC_TRY(count_tile(walk.set));
  bool shows = false;
  if (tile.level + 1 < tiling.levels)
    for (std::uint32_t child = 0; child < tiling.branching; ++child) {
      const TileAddress at{tile.level + 1, 2 * tile.x + (child & 1U), 2 * tile.y + (child >> 1U & 1U),
                           2 * tile.z + (child >> 2U)};
      ZC_ASSIGN(const bool child_shows, walk_implicit(walk, subtree, at, depth + 1, morton * tiling.branching + child));
      shows = shows || child_shows;
    }
  std::vector<std::string> uris;
  for (std::size_t i = 0; i < walk.root.contents.size() && i < subtree.contents.size(); ++i)
    if (subtree.contents[i].at(bit)) uris.push_back(fill_template(walk.root.contents[i], tile));
  if (uris.empty()) return shows;
  if (!location_.is_known())
    if (Status seen = location_.see(part_of(walk.root.volume, tile, tiling.branching), walk.transform); !seen.ok())
      return Error{seen.error().code, seen.error().message, walk.set.path.string()};
  ZC_ASSIGN(const bool own, walk_contents(walk.set, uris, walk.transform, !walk.root.adds && shows));
  return shows || own;
}

Status TileWalk::count_tile(const TilesetFile& set) {
  return ++tiles_ > kMaxTiles ? Status(too_many(set, kMaxTiles, "tiles")) : Status();
}

Status TileWalk::add(const TilesetFile& set, const std::filesystem::path& file, const glm::dmat4& transform) {
  const auto [known, is_new] = known_.try_emplace({file.string(), set.up}, contents_.size());
  if (is_new) contents_.push_back({file, set.up, {}});
  std::vector<glm::dmat4>& places = contents_[known->second].places;
  if (++placed_ > kMaxContents) return too_many(set, kMaxContents, "contents");
  places.push_back(transform);
  return {};
}

}  // namespace zc
