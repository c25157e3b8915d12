// SPDX-License-Identifier: GPL-3.0-or-later
// Contents of 3D Tiles into the scene, recognised by their first bytes: b3dm, i3dm, cmpt, GLB, glTF. Points and vectors
// (pnts, vctr, geom) are counted in the notes. Source: OGC 22-025r4 (3D Tiles 1.1), sections 10 and 12.
// Borrows all it is given. Untrusted input. Not thread-safe.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "baker/import/gltf/gltf_import.h"
#include "baker/import/tiles/tile_files.h"

namespace zc {

// Whether a file with these first bytes is a tile's content that no glTF importer reads.
[[nodiscard]] bool is_tile_content(std::string_view head);

// The RTC_CENTER of the first model in a b3dm, i3dm or cmpt, for one that comes without a tileset; nothing where there
// is none or the content is damaged.
[[nodiscard]] std::optional<glm::dvec3> center_of_content(std::span<const std::byte> bytes);

class TileContents {
 public:
  TileContents(std::filesystem::path root, TileFiles& files, TextureImages& images, SceneBuilder& builder)
      : root_(std::move(root)), files_(files), images_(images), builder_(builder) {}

  // The model stands at each of the places. Fails when lengths disagree with the file, on headers from before 1.0 and
  // on any other kind of content.
  Status add(std::vector<std::byte> bytes, const std::filesystem::path& file, UpAxis up,
             const std::vector<glm::dmat4>& places);
  // Models in files of their own, which instances of any number of tiles show. Once, when all tiles are added.
  Status finish();

 private:
  class Reader;
  struct Model {
    std::filesystem::path file;
    UpAxis up = UpAxis::kY;
    std::vector<glm::dmat4> places;
  };

  const std::filesystem::path root_;
  TileFiles& files_;
  TextureImages& images_;
  SceneBuilder& builder_;
  std::vector<Model> models_;  // of i3dm, by URI, in order of first use
  std::map<std::pair<std::string, UpAxis>, std::size_t> known_models_;
  std::uint64_t instances_ = 0;
};

}  // namespace zc
