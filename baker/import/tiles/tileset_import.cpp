// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/tiles/tileset_import.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "baker/import/shared/json_text.h"
#include "baker/import/shared/uri.h"
#include "baker/import/tiles/tile_content.h"
#include "base/file.h"

namespace zc {
namespace {

using nlohmann::json;

constexpr std::uint64_t kMaxTilesetBytes = std::uint64_t{1} << 32U;
constexpr std::size_t kMaxExternalDepth = 32;
// A few external tilesets that name each other twice make 2^32 tiles.
constexpr std::size_t kMaxTiles = std::size_t{1} << 22U;
constexpr const char* kMultipleContents = "3DTILES_multiple_contents";
constexpr std::array<std::string_view, 3> kHandled = {"3DTILES_content_gltf", "3DTILES_metadata", kMultipleContents};

// Distances from the earth's centre at which cities lie. A projected northing can be as long, but never far above 0.
constexpr double kNearestM = 6.3e6;
constexpr double kFarthestM = 6.45e6;
constexpr double kHighestM = 2e4;
// Regions wider than this say nothing of where the city is.
constexpr double kWideRegionRad = 0.1;

struct PlacedContent {
  std::filesystem::path file;
  glm::dmat4 to_tileset;
  UpAxis up;
};

// Finds the contents to show and where the tileset is on the earth, before any is read.
class TilesetWalk {
 public:
  explicit TilesetWalk(const std::filesystem::path& path) : root_(folder_of(path)) {}

  Status visit_tileset(std::string_view text, const std::filesystem::path& path, const glm::dmat4& transform) {
    if (std::find(open_.begin(), open_.end(), path) != open_.end())
      return Error{ErrorCode::kFormat, "external tileset contains itself", path.string()};
    if (open_.size() > kMaxExternalDepth)
      return Error{ErrorCode::kUnsupported,
                   "external tilesets nest deeper than " + std::to_string(kMaxExternalDepth) + " levels",
                   path.string()};
    ZC_ASSIGN(const json document, parse_json(text, path.string()));
    Tileset set{path, UpAxis::kY};
    ZC_TRY(read_header(document, set));
    const json* root = find_member(document, "root");
    if (root == nullptr) return error(set, "tileset has no root");
    open_.push_back(path);
    ZC_TRY(visit(*root, set, transform, false, "root tile"));
    open_.pop_back();
    return {};
  }

  [[nodiscard]] const std::filesystem::path& root() const { return root_; }
  [[nodiscard]] const std::vector<PlacedContent>& contents() const { return contents_; }
  // Nothing when the tileset is not geocentric.
  [[nodiscard]] const std::optional<Geodetic>& origin() const { return origin_ ? origin_ : wide_origin_; }
  // Of a tileset that zonecast wrote, else empty.
  [[nodiscard]] const std::string& crs() const { return crs_; }

 private:
  struct Tileset {
    std::filesystem::path path;
    UpAxis up;
  };

  static Error error(const Tileset& set, std::string message) {
    return {ErrorCode::kFormat, std::move(message), set.path.string()};
  }
  static Error unsupported(const Tileset& set, std::string message) {
    return {ErrorCode::kUnsupported, std::move(message), set.path.string()};
  }

  Status read_header(const json& document, Tileset& set) {
    const auto text_of = [](const json* object, const char* key) {
      const json* member = object != nullptr ? find_member(*object, key) : nullptr;
      return member != nullptr && member->is_string() ? member->get<std::string>() : std::string();
    };
    const json* asset = find_member(document, "asset");
    const std::string version = text_of(asset, "version");
    if (version != "1.0" && version != "1.1")
      return unsupported(set, "3D Tiles version '" + one_line(version) + "', only 1.0 and 1.1 are read");
    const std::string up = text_of(asset, "gltfUpAxis");
    if (up == "X" || up == "x")
      set.up = UpAxis::kX;
    else if (up == "Z" || up == "z")
      set.up = UpAxis::kZ;
    else if (!up.empty() && up != "Y" && up != "y")
      return error(set, "gltfUpAxis is '" + one_line(up) + "'");
    if (const json* required = find_member(document, "extensionsRequired"); required != nullptr) {
      if (!required->is_array()) return error(set, "extensionsRequired is not an array");
      for (const json& name : *required)
        if (!name.is_string() || std::find(kHandled.begin(), kHandled.end(), name.get<std::string>()) == kHandled.end())
          return unsupported(set, "requires the extension " +
                                      one_line(name.is_string() ? name.get<std::string>() : "?") +
                                      ", which is not handled");
    }
    const json* extras = find_member(document, "extras");
    if (open_.empty() && !text_of(extras, "zonecast_index").empty()) crs_ = text_of(extras, "crs");
    return {};
  }

  // `adds`: the parent's refinement, which a tile without its own inherits.
  Status visit(const json& tile, const Tileset& set, const glm::dmat4& parent, bool adds, const std::string& where) {
    if (!tile.is_object()) return error(set, where + " is not an object");
    if (++tiles_ > kMaxTiles) return unsupported(set, "has more than " + std::to_string(kMaxTiles) + " tiles");
    const json* extensions = find_member(tile, "extensions");
    if (find_member(tile, "implicitTiling") != nullptr ||
        (extensions != nullptr && find_member(*extensions, "3DTILES_implicit_tiling") != nullptr))
      return unsupported(set, where + " has implicit tiling, which is not imported");
    glm::dmat4 transform = parent;
    if (const json* member = find_member(tile, "transform"); member != nullptr) {
      const auto numbers = as_numbers(*member, 16);
      if (!numbers) return error(set, where + " has a transform that is not 16 numbers");
      glm::dmat4 local;
      for (std::size_t i = 0; i < 16; ++i) local[static_cast<int>(i / 4)][static_cast<int>(i % 4)] = (*numbers)[i];
      transform = parent * local;
    }
    if (const json* refine = find_member(tile, "refine"); refine != nullptr) {
      adds = *refine == "ADD";
      if (!adds && *refine != "REPLACE") return error(set, where + " has a refine that is neither ADD nor REPLACE");
    }
    ZC_TRY(locate(tile, set, transform, where));

    const std::size_t before = contents_.size();
    if (const json* children = find_member(tile, "children"); children != nullptr) {
      if (!children->is_array()) return error(set, where + " has children that are not an array");
      for (std::size_t i = 0; i < children->size(); ++i)
        ZC_TRY(visit((*children)[i], set, transform, adds, where + "/" + std::to_string(i)));
    }
    const bool is_replaced = !adds && contents_.size() > before;
    ZC_ASSIGN(const std::vector<std::string> uris, content_uris(tile, set, where));
    for (const std::string& uri : uris) {
      ZC_ASSIGN(const std::filesystem::path file, file_of_uri(uri, set.path, root_));
      if (file.extension() == ".json") {
        // An external tileset is a child of its tile.
        ZC_ASSIGN(const std::vector<std::byte> bytes, read_file(file, kMaxTilesetBytes));
        const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
        if (is_tileset(text)) {
          ZC_TRY(visit_tileset(text, file, transform));
          continue;
        }
      }
      if (!is_replaced) contents_.push_back({file, transform, set.up});
    }
    return {};
  }

  static Result<std::vector<std::string>> content_uris(const json& tile, const Tileset& set, const std::string& where) {
    std::vector<const json*> contents;
    if (const json* content = find_member(tile, "content"); content != nullptr) contents.push_back(content);
    const json* several = find_member(tile, "contents");
    if (const json* extensions = find_member(tile, "extensions"); several == nullptr && extensions != nullptr)
      if (const json* extension = find_member(*extensions, kMultipleContents); extension != nullptr) {
        several = find_member(*extension, "contents");
        if (several == nullptr) several = find_member(*extension, "content");
      }
    if (several != nullptr) {
      if (!several->is_array()) return error(set, where + " has contents that are not an array");
      for (const json& content : *several) contents.push_back(&content);
    }
    std::vector<std::string> uris;
    for (const json* content : contents) {
      const json* uri = find_member(*content, "uri");
      if (uri == nullptr) uri = find_member(*content, "url");
      if (uri == nullptr || !uri->is_string()) return error(set, where + " has a content without a uri");
      uris.push_back(uri->get<std::string>());
    }
    return uris;
  }

  // The first volume, from the root down, that lies in one place on the earth is where the tileset is.
  Status locate(const json& tile, const Tileset& set, const glm::dmat4& transform, const std::string& where) {
    const json* volume = find_member(tile, "boundingVolume");
    if (origin_ || volume == nullptr) return {};
    if (const json* member = find_member(*volume, "region"); member != nullptr) {
      const auto region = as_numbers(*member, 6);
      if (!region) return error(set, where + " has a region that is not six numbers");
      const double west = (*region)[0];
      const double south = (*region)[1];
      const double east = (*region)[2];
      const double north = (*region)[3];
      constexpr double kQuarter = 1.571;  // of a turn, a little more for rounding
      if (std::abs(south) > kQuarter || std::abs(north) > kQuarter || std::abs(west) > 2 * kQuarter ||
          std::abs(east) > 2 * kQuarter)
        return error(set, where + " has a region that is not on the earth");
      const double width = east < west ? east - west + 2 * std::numbers::pi : east - west;  // may cross 180°
      const Geodetic center{glm::degrees(west + width / 2), glm::degrees((south + north) / 2),
                            ((*region)[4] + (*region)[5]) / 2};
      const bool is_wide = width > kWideRegionRad || north - south > kWideRegionRad;
      if (!is_wide)
        origin_ = center;
      else if (!wide_origin_)
        wide_origin_ = center;
      return {};
    }
    for (const auto& [key, count] : {std::pair{"box", std::size_t{12}}, {"sphere", std::size_t{4}}}) {
      const json* member = find_member(*volume, key);
      const auto numbers = member != nullptr ? as_numbers(*member, count) : std::nullopt;
      if (!numbers) continue;
      const glm::dvec3 center(transform * glm::dvec4((*numbers)[0], (*numbers)[1], (*numbers)[2], 1));
      const double distance = glm::length(center);
      if (distance > kNearestM && distance < kFarthestM && std::abs(center.z) > kHighestM)
        origin_ = geodetic_of(center);
    }
    return {};
  }

  std::filesystem::path root_;
  std::vector<std::filesystem::path> open_;  // from the input down to the tileset being walked
  std::vector<PlacedContent> contents_;
  std::size_t tiles_ = 0;
  std::optional<Geodetic> origin_;
  std::optional<Geodetic> wide_origin_;
  std::string crs_;
};

}  // namespace

bool is_tileset(std::string_view text) {
  return has_top_level_key(text, "geometricError") || has_top_level_key(text, "root");
}

Status import_tileset(std::string_view text, const std::string& path, std::optional<EarthFrame>& earth,
                      TextureImages& images, SceneBuilder& builder) {
  const std::filesystem::path file = std::filesystem::path(path).lexically_normal();
  TilesetWalk walk(file);
  ZC_TRY(walk.visit_tileset(text, file, glm::dmat4(1)));
  GltfPlace place;
  place.root = walk.root();
  glm::dmat4 to_world(1);
  if (walk.origin()) {
    if (!earth) earth.emplace(*walk.origin());
    to_world = earth->from_geocentric();
  }
  ZC_TRY(builder.set_crs(walk.origin() ? earth->crs() : walk.crs(), path));
  for (const PlacedContent& content : walk.contents()) {
    place.to_world = to_world * content.to_tileset;
    place.up = content.up;
    ZC_TRY(import_tile_content(content.file, place, images, builder));
  }
  return {};
}

}  // namespace zc
