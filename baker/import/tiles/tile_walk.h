// SPDX-License-Identifier: GPL-3.0-or-later
// Finds the contents to show of a tileset and where it is on the earth, before any is read: of tiles that their
// children replace, the finest; of the others, all. Every file of tiles is read once, however often it is named.
// Untrusted input: tiles, contents and nesting are bounded for the input as a whole. Not thread-safe.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "baker/import/tiles/subtree.h"
#include "baker/import/tiles/tile_files.h"
#include "baker/import/tiles/tileset_file.h"

namespace zc {

// A file, in the order in which they are shown first, and everywhere that it stands.
struct PlacedContent {
  std::filesystem::path file;
  UpAxis up = UpAxis::kY;
  std::vector<glm::dmat4> places;  // in the tileset's frame
};

class TileWalk {
 public:
  // No file may lie outside `root`.
  TileWalk(std::filesystem::path root, TileFiles& files) : root_(std::move(root)), files_(files) {}

  // Fails on cycles, on damaged tilesets and beyond the bounds.
  Status run(TilesetFile tileset);
  [[nodiscard]] const std::vector<PlacedContent>& contents() const { return contents_; }
  [[nodiscard]] const std::optional<Geodetic>& origin() const { return location_.origin(); }

 private:
  using Place = std::array<double, 16>;
  struct External {
    std::optional<TilesetFile> tileset;  // nothing: it is not there
    bool is_content = false;             // or no tileset at all
    bool is_open = false;                // while it is walked
    std::map<Place, bool> shows;         // by place: whether it has contents
  };
  struct OpenTile {
    std::size_t index = 0;
    glm::dmat4 transform{1};
    bool shows = false;
  };
  struct ImplicitWalk {
    const TilesetFile& set;
    const Tile& root;
    const glm::dmat4& transform;
  };

  Result<bool> walk_tileset(const TilesetFile& set, const glm::dmat4& transform);
  Result<bool> walk_contents(const TilesetFile& set, const std::vector<std::string>& uris, const glm::dmat4& transform,
                             bool is_replaced);
  Result<bool> walk_external(External& external, const std::filesystem::path& file, const glm::dmat4& transform);
  Result<External*> external_at(const std::filesystem::path& file);
  Result<bool> walk_subtree(const ImplicitWalk& walk, const TileAddress& top);
  Result<bool> walk_implicit(const ImplicitWalk& walk, const Subtree& subtree, const TileAddress& tile,
                             std::uint32_t depth, std::uint64_t morton);
  Status count_tile(const TilesetFile& set);
  Status add(const TilesetFile& set, const std::filesystem::path& file, const glm::dmat4& transform);

  const std::filesystem::path root_;
  TileFiles& files_;
  TileLocation location_;
  std::vector<PlacedContent> contents_;
  std::map<std::pair<std::string, UpAxis>, std::size_t> known_;  // in contents_
  std::map<std::string, std::unique_ptr<External>> externals_;
  std::size_t nesting_ = 0;
  std::size_t tiles_ = 0;
  std::size_t placed_ = 0;
  std::size_t externals_placed_ = 0;
};

}  // namespace zc
