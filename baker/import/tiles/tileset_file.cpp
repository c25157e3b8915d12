// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/tiles/tileset_file.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "baker/import/shared/json_text.h"

namespace zc {
namespace {

using nlohmann::json;

constexpr const char* kMultipleContents = "3DTILES_multiple_contents";
constexpr const char* kImplicitTiling = "3DTILES_implicit_tiling";
constexpr std::array<std::string_view, 5> kHandled = {"3DTILES_content_gltf", "3DTILES_metadata", kMultipleContents,
                                                      kImplicitTiling, "3DTILES_bounding_volume_S2"};
// Coordinates of a deeper level have no place in 32 bits, nor have a subtree's bits in any file.
constexpr std::uint64_t kMaxImplicitLevels = 31;
constexpr std::uint64_t kMaxSubtreeLevels = 15;

std::string text_of(const json* object, const char* key) {
  const json* member = object != nullptr ? find_member(*object, key) : nullptr;
  return member != nullptr && member->is_string() ? member->get<std::string>() : std::string();
}

const json* extension_of(const json& object, const char* name) {
  const json* extensions = find_member(object, "extensions");
  return extensions != nullptr ? find_member(*extensions, name) : nullptr;
}

class TilesetReader {
 public:
  explicit TilesetReader(const std::filesystem::path& path) { set_.path = path; }

  Result<TilesetFile> run(std::string_view text) {
    ZC_ASSIGN(const json document, parse_small_json(text, set_.path.string()));
    ZC_TRY(read_header(document));
    const json* root = find_member(document, "root");
    if (root == nullptr) return error("tileset has no root: it is damaged or no tileset, get it again");
    ZC_TRY(read_tile(*root, false, "root tile"));
    return std::move(set_);
  }

 private:
  [[nodiscard]] Error error(std::string message) const {
    return {ErrorCode::kFormat, std::move(message), set_.path.string()};
  }
  [[nodiscard]] Error unsupported(std::string message) const {
    return {ErrorCode::kUnsupported, std::move(message), set_.path.string()};
  }

  Status read_header(const json& document) {
    const std::string version = text_of(find_member(document, "asset"), "version");
    if (version != "1.0" && version != "1.1")
      return unsupported("3D Tiles version '" + one_line(version) +
                         "', only 1.0 and 1.1 are read; convert the tileset, for example with 3d-tiles-tools from "
                         "npm: 3d-tiles-tools upgrade -i tileset.json -o new");
    const std::string up = text_of(find_member(document, "asset"), "gltfUpAxis");
    if (up == "X" || up == "x")
      set_.up = UpAxis::kX;
    else if (up == "Z" || up == "z")
      set_.up = UpAxis::kZ;
    else if (!up.empty() && up != "Y" && up != "y")
      return error("gltfUpAxis is '" + one_line(up) + "', expected X, Y or Z");
    if (const json* required = find_member(document, "extensionsRequired"); required != nullptr) {
      if (!required->is_array()) return error("extensionsRequired is not an array");
      for (const json& name : *required)
        if (!name.is_string() || std::find(kHandled.begin(), kHandled.end(), name.get<std::string>()) == kHandled.end())
          return unsupported("requires the extension " + one_line(name.is_string() ? name.get<std::string>() : "?") +
                             ", which is not handled; write the tileset without it");
    }
    const json* extras = find_member(document, "extras");
    if (!text_of(extras, "zonecast_index").empty()) set_.crs = text_of(extras, "crs");
    return {};
  }

  // `adds`: the parent's refinement, which a tile without its own inherits. As deep as JSON may nest.
  Status read_tile(const json& tile, bool adds, const std::string& where) {
    if (!tile.is_object()) return error(where + " is not an object");
    const std::size_t index = set_.tiles.size();
    Tile read;
    if (const json* member = find_member(tile, "transform"); member != nullptr) {
      const auto numbers = as_numbers(*member, 16);
      if (!numbers) return error(where + " has a transform that is not 16 numbers");
      for (std::size_t i = 0; i < 16; ++i)
        read.transform[static_cast<int>(i / 4)][static_cast<int>(i % 4)] = (*numbers)[i];
    }
    if (const json* refine = find_member(tile, "refine"); refine != nullptr) {
      adds = *refine == "ADD";
      if (!adds && *refine != "REPLACE") return error(where + " has a refine that is neither ADD nor REPLACE");
    }
    read.adds = adds;
    if (const json* volume = find_member(tile, "boundingVolume"); volume != nullptr) read.volume = read_volume(*volume);
    ZC_ASSIGN(read.contents, content_uris(tile, where));
    const json* implicit = find_member(tile, "implicitTiling");
    if (implicit == nullptr) implicit = extension_of(tile, kImplicitTiling);
    if (implicit != nullptr) {
      ZC_ASSIGN(read.implicit, read_implicit(*implicit, where));
    }
    set_.tiles.push_back(std::move(read));
    if (const json* children = find_member(tile, "children"); children != nullptr) {
      if (!children->is_array()) return error(where + " has children that are not an array");
      if (implicit != nullptr && !children->empty())
        return error(where + " has implicit tiling and children, of which a tile has one");
      for (std::size_t i = 0; i < children->size(); ++i)
        ZC_TRY(read_tile((*children)[i], adds, where + "/" + std::to_string(i)));
    }
    set_.tiles[index].end = set_.tiles.size();
    return {};
  }

  [[nodiscard]] Result<std::vector<std::string>> content_uris(const json& tile, const std::string& where) const {
    if (const json* several = find_member(tile, "contents"); several != nullptr && !several->is_array())
      return error(where + " has contents that are not an array");
    std::vector<std::string> uris;
    for (const json* content : all_of(tile, "content", "contents")) {
      const json* uri = find_member(*content, "uri");
      if (uri == nullptr) uri = find_member(*content, "url");
      if (uri == nullptr || !uri->is_string()) return error(where + " has a content without a uri");
      uris.push_back(uri->get<std::string>());
    }
    return uris;
  }

  [[nodiscard]] Result<ImplicitTiling> read_implicit(const json& implicit, const std::string& where) const {
    ImplicitTiling tiling;
    const std::string scheme = text_of(&implicit, "subdivisionScheme");
    if (scheme != "QUADTREE" && scheme != "OCTREE")
      return error(where + " has implicit tiling with the subdivisionScheme '" + one_line(scheme) +
                   "', expected QUADTREE or OCTREE");
    tiling.branching = scheme == "OCTREE" ? 8 : 4;
    const auto number = [&](const char* key) {
      const json* member = find_member(implicit, key);
      return member != nullptr ? as_unsigned(*member) : std::nullopt;
    };
    auto levels = number("availableLevels");
    if (const auto last = number("maximumLevel"); !levels && last && *last < kMaxImplicitLevels)
      levels = *last + 1;  // as drafts of the extension have it
    const auto subtree_levels = number("subtreeLevels");
    if (!levels || *levels == 0 || !subtree_levels || *subtree_levels == 0)
      return error(where + " has implicit tiling without availableLevels or subtreeLevels of 1 or more");
    if (*levels > kMaxImplicitLevels || *subtree_levels > kMaxSubtreeLevels)
      return unsupported(where + " has implicit tiling of " + std::to_string(*levels) + " levels, " +
                         std::to_string(*subtree_levels) + " a subtree: at most " + std::to_string(kMaxImplicitLevels) +
                         " and " + std::to_string(kMaxSubtreeLevels) + " are read");
    tiling.levels = static_cast<std::uint32_t>(*levels);
    tiling.subtree_levels = static_cast<std::uint32_t>(*subtree_levels);
    tiling.subtrees = text_of(find_member(implicit, "subtrees"), "uri");
    if (tiling.subtrees.empty()) return error(where + " has implicit tiling without a uri of its subtrees");
    // Otherwise one file would stand for every subtree of every level, which no number of levels bounds.
    if (tiling.levels > tiling.subtree_levels)
      for (const char* variable : {"{level}", "{x}", "{y}", "{z}"})
        if (tiling.subtrees.find(variable) == std::string::npos && (variable[1] != 'z' || tiling.branching == 8))
          return error(where + " has a uri of its subtrees without " + variable);
    return tiling;
  }

  TilesetFile set_;
};

}  // namespace

std::vector<const json*> all_of(const json& object, const char* single, const char* several) {
  std::vector<const json*> all;
  const auto add = [&](const json* members) {
    if (members == nullptr) return;
    if (!members->is_array()) {
      all.push_back(members);
      return;
    }
    for (const json& member : *members) all.push_back(&member);
  };
  if (std::string_view(single) != several) add(find_member(object, single));
  const json* list = find_member(object, several);
  if (const json* extension = extension_of(object, kMultipleContents); list == nullptr && extension != nullptr) {
    list = find_member(*extension, several);
    if (list == nullptr) list = find_member(*extension, single);
  }
  add(list);
  return all;
}

bool is_tileset(std::string_view text) {
  return has_top_level_key(text, "geometricError") || has_top_level_key(text, "root");
}

Result<TilesetFile> read_tileset(std::string_view text, const std::filesystem::path& path) {
  return TilesetReader(path).run(text);
}

}  // namespace zc
