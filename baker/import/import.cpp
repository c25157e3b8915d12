// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/import.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <new>
#include <optional>
#include <string>
#include <string_view>

#include "baker/import/citygml/citygml_import.h"
#include "baker/import/cityjson/cityjson_import.h"
#include "baker/import/gltf/gltf_import.h"
#include "baker/import/shared/earth_frame.h"
#include "baker/import/shared/gunzip.h"
#include "baker/import/shared/json_text.h"
#include "baker/import/shared/scene_builder.h"
#include "baker/import/shared/texture_images.h"
#include "baker/import/shared/uri.h"
#include "baker/import/tiles/tile_content.h"
#include "baker/import/tiles/tile_files.h"
#include "baker/import/tiles/tileset_file.h"
#include "baker/import/tiles/tileset_import.h"
#include "baker/import/tiles/zip_files.h"
#include "base/file.h"
#include "streamer/source/source.h"

namespace zc {
namespace {

constexpr std::uint64_t kMaxInputBytes = std::uint64_t{1} << 34U;
constexpr const char* kBlank = " \t\r\n";

// A sequence of documents: the first line is closed and another object begins after it, which one JSON document never
// does. Reads no further than that.
bool is_sequence(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  char last = 0;
  for (char c = 0; file.get(c) && c != '\n';)
    if (std::string_view(kBlank).find(c) == std::string_view::npos) last = c;
  if (last != '}') return false;
  for (char c = 0; file.get(c);)
    if (std::string_view(kBlank).find(c) == std::string_view::npos) return c == '{';
  return path.extension() == ".jsonl";  // a header and nothing else
}

// A pipe or a device, which can be read but once. Names that lead nowhere are left to who opens them.
bool is_stream(const std::filesystem::path& input) {
  std::error_code failure;
  const std::filesystem::file_status status = std::filesystem::status(input, failure);
  return std::filesystem::is_fifo(status) || std::filesystem::is_character_file(status) ||
         std::filesystem::is_socket(status);
}

Result<std::ifstream> open_stream(const std::filesystem::path& file, const std::string& path) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return Error{ErrorCode::kIo, std::string("cannot open: ") + std::strerror(errno), path};
  return stream;
}

Status import_one(const std::filesystem::path& input, const ImportOptions& options, std::optional<EarthFrame>& earth,
                  TextureImages& images, SceneBuilder& builder) {
  if (is_url(input.native())) return import_web_tiles(input.native(), options.skip_missing, earth, images, builder);
  const bool is_standard_input = input == "-";
  const std::string path = is_standard_input ? "standard input" : input.string();
  builder.enter_file(path);
  if (is_standard_input || is_stream(input)) {
    ZC_ASSIGN(std::ifstream stream, open_stream(is_standard_input ? "/dev/stdin" : input, path));
    return import_cityjson_seq(stream, path, {}, images, builder);
  }
  ZC_ASSIGN(const InputFile file, InputFile::open(input));
  std::vector<std::byte> head(std::min<std::uint64_t>(file.size_bytes(), 64));
  ZC_TRY(file.read(0, head));
  std::string_view text(reinterpret_cast<const char*>(head.data()), head.size());
  if (is_zip(head)) return import_tiles_archive(input, options.skip_missing, earth, images, builder);
  std::vector<std::byte> bytes;
  if (is_gzip(head)) {
    ZC_ASSIGN(const std::vector<std::byte> packed, read_file(input, kMaxInputBytes));
    ZC_ASSIGN(bytes, gunzip(packed, path, kMaxUnpackedBytes));
    text = {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
  const TilesetSource tiles{.skip_missing = options.skip_missing};
  if (is_tile_content(text)) {
    if (bytes.empty()) {
      ZC_ASSIGN(bytes, read_file(input, kMaxInputBytes));
    }
    return import_tileset(std::move(bytes), input, tiles, earth, images, builder);
  }
  const bool is_glb = text.starts_with("glTF");
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  const std::size_t start = text.find_first_not_of(kBlank);
  if (head.empty()) return Error{ErrorCode::kFormat, "is empty", path};
  const bool is_xml = start != std::string_view::npos && text[start] == '<';
  if (!is_glb && !is_xml && (start == std::string_view::npos || text[start] != '{'))
    return Error{
        ErrorCode::kUnsupported,
        "is neither glTF, GLB, CityJSON, CityJSONSeq, CityGML nor 3D Tiles (tileset.json, .3tz, b3dm, i3dm, cmpt)",
        path, 0};
  if (!is_glb && !is_xml && bytes.empty() && is_sequence(input)) {
    ZC_ASSIGN(std::ifstream stream, open_stream(input, path));
    return import_cityjson_seq(stream, path, input, images, builder);
  }

  if (bytes.empty()) {
    ZC_ASSIGN(bytes, read_file(input, kMaxInputBytes));
  }
  GltfPlace place;
  place.root = folder_of(input);
  if (is_xml) return import_citygml(std::move(bytes), path, earth, images, builder);
  if (is_glb) return import_gltf(std::move(bytes), path, place, images, builder);
  text = {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  if (is_tileset(text)) return import_tileset(std::move(bytes), input, tiles, earth, images, builder);
  // glTF 1.0 may have no asset.
  const bool is_gltf = (has_top_level_key(text, "asset") || has_top_level_key(text, "meshes")) &&
                       !has_top_level_key(text, "CityObjects");
  if (is_gltf) return import_gltf(std::move(bytes), path, place, images, builder);
  return import_cityjson(text, path, images, builder);
}

// What was left out instead, for who expected something to show.
std::string why_empty(std::span<const ImportCount> notes) {
  constexpr std::size_t kNotesShown = 5;
  if (notes.empty()) return ": it contains no surfaces; check that it is the file you meant";
  std::string why;
  for (std::size_t i = 0; i < std::min(notes.size(), kNotesShown); ++i)
    why += (i == 0 ? "; " : ", ") + notes[i].what + ": " + std::to_string(notes[i].count);
  return why;
}

}  // namespace

Result<Scene> import_inputs(std::span<const std::filesystem::path> inputs, const ImportOptions& options) {
  if (inputs.empty()) return Error{ErrorCode::kArgument, "no input given"};
  SceneBuilder builder;
  std::optional<EarthFrame> earth;
  TextureImages images;
  std::vector<std::string> without_crs;
  for (const std::filesystem::path& input : inputs) {
    const std::uint64_t crs_named = builder.crs_named();
    try {
      if (Status status = import_one(input, options, earth, images, builder); !status.ok()) {
        Error error = std::move(status).error();
        if (error.path.empty()) error.path = input.empty() ? "''" : input.string();
        return error;
      }
    } catch (const std::bad_alloc&) {
      return Error{ErrorCode::kBudget, "not enough memory to import this file", input.string()};
    }
    if (builder.crs_named() == crs_named) without_crs.push_back(input.string());
  }
  builder.enter_file({});
  if (builder.crs_named() > 0)
    builder.note_files("inputs without a reference system, taken to be in that of the others", without_crs);
  images.report(builder);
  Scene scene = builder.finish(images.take());
  if (scene.triangles.empty())
    return Error{ErrorCode::kFormat, "has no triangles" + why_empty(scene.notes), inputs.front().string()};
  return scene;
}

}  // namespace zc
