// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/tiles/tile_content.h"

#include <algorithm>
#include <array>
#include <glm/gtc/matrix_transform.hpp>
#include <span>
#include <string_view>
#include <utility>

#include "baker/import/shared/json_text.h"
#include "baker/import/shared/uri.h"
#include "baker/import/tiles/feature_table.h"
#include "baker/import/tiles/tile_instances.h"

namespace zc {
namespace {

using Bytes = std::span<const std::byte>;

constexpr std::uint64_t kMaxModelBytes = std::uint64_t{1} << 34U;
constexpr std::size_t kB3dmHeaderBytes = 28;
constexpr std::size_t kI3dmHeaderBytes = 32;
constexpr std::size_t kCmptHeaderBytes = 16;
constexpr int kMaxCompositeDepth = 16;
// Of an input as a whole, each tile's counted wherever the tile stands.
constexpr std::uint64_t kMaxInstances = std::uint64_t{1} << 20U;
constexpr std::array<std::string_view, 3> kModels = {"b3dm", "i3dm", "cmpt"};
constexpr std::array<std::pair<std::string_view, std::string_view>, 3> kNoModels = {
    {{"pnts", "points"}, {"vctr", "vectors"}, {"geom", "shapes"}}};

std::string_view text_of(Bytes bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

// GLB, or JSON that only a glTF can be here.
bool is_gltf(std::string_view text) {
  const std::size_t start = text.find_first_not_of(" \t\r\n");
  return text.starts_with("glTF") || (start != std::string_view::npos && text[start] == '{');
}

// What a file is that is none of ours, from its first bytes.
std::string kind_of(Bytes bytes) {
  const std::string_view text = text_of(bytes);
  constexpr std::array<std::pair<std::string_view, const char*>, 7> kKinds = {
      {{"PK\x03\x04", "a ZIP archive"},
       {"\x89PNG", "a PNG image"},
       {"\xFF\xD8\xFF", "a JPEG image"},
       {"\x28\xB5\x2F\xFD", "Zstandard data"},
       {"subt", "a subtree"},
       {"<", "HTML or XML"},
       {"version https://git-lfs", "a pointer of Git LFS"}}};
  if (text.empty()) return "empty";
  for (const auto& [start, kind] : kKinds)
    if (text.starts_with(start)) return kind;
  return "a file that begins with '" + one_line(text.substr(0, 4)) + "'";
}

struct Tables {
  FeatureTable features;
  Bytes body;  // behind the tables
  std::size_t body_at = 0;
};

}  // namespace

// One file at its places.
class TileContents::Reader {
 public:
  Reader(TileContents& all, const std::filesystem::path& file, UpAxis up, const std::vector<glm::dmat4>& places)
      : all_(all), file_(file), path_(file.string()), up_(up), places_(places) {}

  // `at` is the place of `bytes` in the file.
  Status add(Bytes bytes, std::size_t at, int depth = 0) {
    const std::string_view text = text_of(bytes);
    if (text.starts_with("glTF") || (depth == 0 && is_gltf(text))) return add_gltf(bytes, at, glm::dvec3(0));
    const std::string kind(text.substr(0, 4));
    const auto other = std::ranges::find(kNoModels, kind, [](const auto& pair) { return pair.first; });
    if (other == kNoModels.end() && std::ranges::find(kModels, kind) == kModels.end())
      return Error{ErrorCode::kUnsupported,
                   "tile content is neither b3dm, cmpt, i3dm, pnts, GLB nor glTF: it is " + kind_of(bytes) +
                       "; get the file again or take it out of the tileset",
                   path_, static_cast<std::int64_t>(at)};
    if (bytes.size() < 12) return fault(kind + " header is cut short", at + bytes.size());
    if (const auto version = load_number<std::uint32_t>(bytes, 4); version != 1)
      return Error{ErrorCode::kUnsupported, kind + " version " + std::to_string(version) + ", only 1 is read", path_,
                   static_cast<std::int64_t>(at) + 4};
    const auto length = load_number<std::uint32_t>(bytes, 8);
    if (length > bytes.size())
      return fault("file ends early: " + kind + " declares " + std::to_string(length) + " bytes", at + bytes.size());
    bytes = bytes.first(length);
    if (kind == "b3dm") return add_b3dm(bytes, at);
    if (kind == "i3dm") return add_i3dm(bytes, at);
    if (kind == "cmpt") return add_cmpt(bytes, at, depth);
    all_.builder_.note("tile contents of kind " + kind + " (" + std::string(other->second) + "), left out");
    return {};
  }

  [[nodiscard]] Result<Tables> tables_of(Bytes bytes, std::size_t at, std::size_t header_bytes,
                                         const std::string& kind) const {
    if (bytes.size() < header_bytes) return fault(kind + " header is cut short", at + bytes.size());
    const std::uint64_t json_bytes = load_number<std::uint32_t>(bytes, 12);
    const std::uint64_t binary_bytes = load_number<std::uint32_t>(bytes, 16);
    const std::uint64_t tables_bytes =
        json_bytes + binary_bytes + load_number<std::uint32_t>(bytes, 20) + load_number<std::uint32_t>(bytes, 24);
    const Bytes body = bytes.subspan(header_bytes);
    if (tables_bytes > body.size())
      return fault(kind + " tables of " + std::to_string(tables_bytes) + " bytes reach past the " +
                       std::to_string(bytes.size()) + " bytes of the " + kind,
                   at + 12);
    ZC_ASSIGN(FeatureTable features, FeatureTable::read(body.first(json_bytes), body.subspan(json_bytes, binary_bytes),
                                                        path_, at + header_bytes));
    return Tables{std::move(features), body.subspan(tables_bytes), at + header_bytes + tables_bytes};
  }

 private:
  [[nodiscard]] Error fault(std::string message, std::size_t at) const {
    return {ErrorCode::kFormat, std::move(message), path_, static_cast<std::int64_t>(at)};
  }

  // One place is part of the model's own, so that its positions are rounded once.
  Status add_gltf(Bytes bytes, std::size_t at, const glm::dvec3& center) {
    if (places_.size() == 1) return import(bytes, at, glm::translate(places_.front(), center), {});
    return import(bytes, at, glm::translate(glm::dmat4(1), center), places_);
  }

  Status import(Bytes bytes, std::size_t at, const glm::dmat4& to_world, std::vector<glm::dmat4> instances) {
    GltfPlace place;
    place.to_world = to_world;
    place.up = up_;
    place.root = all_.root_;
    place.files = &all_.files_.from();
    place.byte_offset = static_cast<std::int64_t>(at);
    all_.builder_.set_instances(std::move(instances));
    Status status = import_gltf({bytes.begin(), bytes.end()}, path_, place, all_.images_, all_.builder_);
    all_.builder_.set_instances({});
    return status;
  }

  // magic, version, length, then four lengths: feature table as JSON and binary, batch table likewise; then a GLB.
  Status add_b3dm(Bytes bytes, std::size_t at) {
    Result<Tables> tables = tables_of(bytes, at, kB3dmHeaderBytes, "b3dm");
    if (!tables.ok()) {
      // Headers of 20 and 24 bytes came before 1.0: the GLB or a table's text stands where lengths should.
      for (const std::size_t early : {std::size_t{20}, std::size_t{24}})
        if (bytes.size() >= kB3dmHeaderBytes)
          if (const auto text = text_of(bytes.subspan(early, 4)); text == "glTF" || text.starts_with("{\""))
            return Error{ErrorCode::kUnsupported,
                         "b3dm has a header from before version 1.0; convert the tileset, for example with "
                         "3d-tiles-tools from npm: 3d-tiles-tools upgrade -i tileset.json -o new",
                         path_, static_cast<std::int64_t>(at + early)};
      return std::move(tables).error();
    }
    ZC_ASSIGN(const std::optional<glm::dvec3> center, tables->features.vector("RTC_CENTER"));
    if (!text_of(tables->body).starts_with("glTF"))
      return fault("b3dm contains no GLB behind its tables", tables->body_at);
    return add_gltf(tables->body, tables->body_at, center.value_or(glm::dvec3(0)));
  }

  // As a b3dm; then whether the model's URI (0) or the model (1) comes, and that.
  Status add_i3dm(Bytes bytes, std::size_t at) {
    ZC_ASSIGN(const Tables tables, tables_of(bytes, at, kI3dmHeaderBytes, "i3dm"));
    const auto format = load_number<std::uint32_t>(bytes, 28);
    if (format > 1) return fault("i3dm has the gltfFormat " + std::to_string(format) + ", expected 0 or 1", at + 28);
    const std::uint64_t left = kMaxInstances - all_.instances_;
    ZC_ASSIGN(const std::vector<glm::dmat4> local, read_instances(tables.features, left / places_.size()));
    all_.instances_ += local.size() * places_.size();
    std::vector<glm::dmat4> instances;
    instances.reserve(local.size() * places_.size());
    for (const glm::dmat4& place : places_)
      for (const glm::dmat4& instance : local) instances.push_back(place * instance);
    if (instances.empty()) return {};
    if (format == 1) {
      if (!text_of(tables.body).starts_with("glTF"))
        return fault("i3dm contains no GLB behind its tables", tables.body_at);
      return import(tables.body, tables.body_at, glm::dmat4(1), std::move(instances));
    }
    std::string_view uri = text_of(tables.body);
    uri.remove_suffix(uri.size() - (uri.find_last_not_of(std::string_view(" \0", 2)) + 1));
    ZC_ASSIGN(std::filesystem::path model, file_of_uri(uri, file_, all_.root_));
    const auto [known, is_new] = all_.known_models_.try_emplace({model.string(), up_}, all_.models_.size());
    if (is_new) all_.models_.push_back({std::move(model), up_, {}});
    auto& shown = all_.models_[known->second].places;
    shown.insert(shown.end(), instances.begin(), instances.end());
    return {};
  }

  // magic, version, length, count; then as many contents, each with its own length at byte 8.
  Status add_cmpt(Bytes bytes, std::size_t at, int depth) {
    if (bytes.size() < kCmptHeaderBytes) return fault("cmpt header is cut short", at + bytes.size());
    if (depth == kMaxCompositeDepth)
      return fault("cmpt nests deeper than " + std::to_string(kMaxCompositeDepth) + " levels", at);
    const auto count = load_number<std::uint32_t>(bytes, 12);
    std::size_t place = kCmptHeaderBytes;
    for (std::uint32_t i = 0; i < count; ++i) {
      const Bytes rest = bytes.subspan(place);
      const std::uint32_t length = rest.size() < 12 ? 0 : load_number<std::uint32_t>(rest, 8);
      if (length < 12 || length > rest.size())
        return fault("content " + std::to_string(i) + " of " + std::to_string(count) + " does not fit its cmpt",
                     at + place);
      ZC_TRY(add(rest.first(length), at + place, depth + 1));
      place += length;
    }
    return {};
  }

  TileContents& all_;
  const std::filesystem::path& file_;
  const std::string path_;
  const UpAxis up_;
  const std::vector<glm::dmat4>& places_;
};

bool is_tile_content(std::string_view head) {
  const std::string_view kind = head.substr(0, 4);
  return std::ranges::find(kModels, kind) != kModels.end() ||
         std::ranges::any_of(kNoModels, [&](const auto& other) { return other.first == kind; });
}

std::optional<glm::dvec3> center_of_content(Bytes bytes) {
  for (int depth = 0; depth < kMaxCompositeDepth && text_of(bytes).starts_with("cmpt"); ++depth)
    bytes = bytes.subspan(std::min(bytes.size(), kCmptHeaderBytes));
  if (!is_tile_content(text_of(bytes)) || bytes.size() < kI3dmHeaderBytes) return std::nullopt;
  const bool is_i3dm = text_of(bytes).starts_with("i3dm");
  const Bytes body = bytes.subspan(is_i3dm ? kI3dmHeaderBytes : kB3dmHeaderBytes);
  const auto json_bytes = load_number<std::uint32_t>(bytes, 12);
  const auto binary_bytes = load_number<std::uint32_t>(bytes, 16);
  if (json_bytes > body.size() || binary_bytes > body.size() - json_bytes) return std::nullopt;
  const auto table = FeatureTable::read(body.first(json_bytes), body.subspan(json_bytes, binary_bytes), {}, 0);
  if (!table.ok()) return std::nullopt;
  const auto center = table->vector("RTC_CENTER");
  return center.ok() ? *center : std::nullopt;
}

Status TileContents::add(std::vector<std::byte> bytes, const std::filesystem::path& file, UpAxis up,
                         const std::vector<glm::dmat4>& places) {
  builder_.enter_file(file.string());
  return files_.settle(Reader(*this, file, up, places).add(bytes, 0));
}

Status TileContents::finish() {
  for (const Model& model : models_) {
    ZC_ASSIGN(const std::optional<std::vector<std::byte>> bytes, files_.read(model.file, kMaxModelBytes));
    if (!bytes) continue;
    if (!is_gltf(text_of(*bytes)))
      return Error{ErrorCode::kUnsupported,
                   "model of an i3dm is neither GLB nor glTF: it is " + kind_of(*bytes) + "; get the file again",
                   model.file.string(), 0};
    ZC_TRY(add(*bytes, model.file, model.up, model.places));
  }
  return {};
}

}  // namespace zc
