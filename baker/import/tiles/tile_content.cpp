// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/tiles/tile_content.h"

#include <cstring>
#include <glm/gtc/matrix_transform.hpp>
#include <nlohmann/json.hpp>
#include <span>
#include <string_view>

#include "baker/import/shared/json_text.h"
#include "base/file.h"

namespace zc {
namespace {

using nlohmann::json;
using Bytes = std::span<const std::byte>;

constexpr std::uint64_t kMaxContentBytes = std::uint64_t{1} << 34U;
constexpr std::size_t kB3dmHeaderBytes = 28;
constexpr std::size_t kCmptHeaderBytes = 16;
constexpr int kMaxCompositeDepth = 16;

template <class T>
T load(Bytes bytes, std::size_t at) {
  T value{};
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

std::string_view text_of(Bytes bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

class TileContent {
 public:
  TileContent(const std::string& path, const GltfPlace& place, TextureImages& images, SceneBuilder& builder)
      : path_(path), place_(place), images_(images), builder_(builder) {}

  // `at` is the place of `bytes` in the file.
  Status add(Bytes bytes, std::size_t at, int depth = 0) {
    const std::string_view text = text_of(bytes);
    const std::size_t start = text.find_first_not_of(" \t\r\n");
    if (text.starts_with("glTF") || (depth == 0 && start != std::string_view::npos && text[start] == '{'))
      return add_gltf(bytes, at, glm::dvec3(0));
    const std::string kind(text.substr(0, 4));
    if (kind != "b3dm" && kind != "cmpt" && kind != "i3dm" && kind != "pnts")
      return Error{ErrorCode::kUnsupported, "tile content is neither b3dm, cmpt, i3dm, pnts, GLB nor glTF", path_,
                   static_cast<std::int64_t>(at)};
    if (bytes.size() < 12) return fault(kind + " header is cut short", at + bytes.size());
    if (const auto version = load<std::uint32_t>(bytes, 4); version != 1)
      return Error{ErrorCode::kUnsupported, kind + " version " + std::to_string(version) + ", only 1 is read", path_,
                   static_cast<std::int64_t>(at) + 4};
    const auto length = load<std::uint32_t>(bytes, 8);
    if (length > bytes.size())
      return fault("file ends early: " + kind + " declares " + std::to_string(length) + " bytes", at + bytes.size());
    bytes = bytes.first(length);
    if (kind == "b3dm") return add_b3dm(bytes, at);
    if (kind == "cmpt") return add_cmpt(bytes, at, depth);
    builder_.note("tile contents of kind " + kind + (kind == "pnts" ? " (points)" : " (instances)") + ", left out");
    return {};
  }

 private:
  [[nodiscard]] Error fault(std::string message, std::size_t at) const {
    return {ErrorCode::kFormat, std::move(message), path_, static_cast<std::int64_t>(at)};
  }

  Status add_gltf(Bytes bytes, std::size_t at, const glm::dvec3& center) {
    GltfPlace place = place_;
    place.to_world = glm::translate(place.to_world, center);
    place.byte_offset = static_cast<std::int64_t>(at);
    return import_gltf({bytes.begin(), bytes.end()}, path_, place, images_, builder_);
  }

  // magic, version, length, then four lengths: feature table as JSON and binary, batch table likewise; then a GLB.
  Status add_b3dm(Bytes bytes, std::size_t at) {
    if (bytes.size() < kB3dmHeaderBytes) return fault("b3dm header is cut short", at + bytes.size());
    const std::uint64_t json_bytes = load<std::uint32_t>(bytes, 12);
    const std::uint64_t binary_bytes = load<std::uint32_t>(bytes, 16);
    const std::uint64_t tables_bytes =
        json_bytes + binary_bytes + load<std::uint32_t>(bytes, 20) + load<std::uint32_t>(bytes, 24);
    const Bytes body = bytes.subspan(kB3dmHeaderBytes);
    if (tables_bytes > body.size()) {
      // Headers of 20 and 24 bytes came before 1.0: the GLB or a table's text stands where lengths should.
      for (const std::size_t early : {std::size_t{20}, std::size_t{24}})
        if (const auto text = text_of(bytes.subspan(early, 4)); text == "glTF" || text.starts_with("{\""))
          return Error{ErrorCode::kUnsupported, "b3dm has a header from before version 1.0", path_,
                       static_cast<std::int64_t>(at + early)};
      return fault("b3dm tables of " + std::to_string(tables_bytes) + " bytes reach past the " +
                       std::to_string(bytes.size()) + " bytes of the b3dm",
                   at + 12);
    }
    ZC_ASSIGN(const glm::dvec3 center,
              rtc_center(body.first(json_bytes), body.subspan(json_bytes, binary_bytes), at + kB3dmHeaderBytes));
    const Bytes model = body.subspan(tables_bytes);
    const std::size_t model_at = at + kB3dmHeaderBytes + tables_bytes;
    if (!text_of(model).starts_with("glTF")) return fault("b3dm contains no GLB behind its tables", model_at);
    return add_gltf(model, model_at, center);
  }

  [[nodiscard]] Result<glm::dvec3> rtc_center(Bytes table, Bytes binary, std::size_t at) const {
    std::string_view text = text_of(table);
    text.remove_suffix(text.size() - (text.find_last_not_of(std::string_view(" \t\r\n\0", 5)) + 1));
    if (text.empty()) return glm::dvec3(0);
    ZC_ASSIGN(const json features, parse_json(text, path_, static_cast<std::int64_t>(at)));
    const json* center = find_member(features, "RTC_CENTER");
    if (center == nullptr) return glm::dvec3(0);
    if (const auto numbers = as_numbers(*center, 3)) return glm::dvec3((*numbers)[0], (*numbers)[1], (*numbers)[2]);
    const json* offset = find_member(*center, "byteOffset");
    const auto place = offset != nullptr ? as_unsigned(*offset) : std::nullopt;
    if (!place) return fault("RTC_CENTER is neither three numbers nor a byteOffset", at);
    if (binary.size() < 12 || *place > binary.size() - 12)
      return fault("RTC_CENTER reaches past the " + std::to_string(binary.size()) + " bytes of the feature table", at);
    return glm::dvec3(load<float>(binary, *place), load<float>(binary, *place + 4), load<float>(binary, *place + 8));
  }

  // magic, version, length, count; then as many contents, each with its own length at byte 8.
  Status add_cmpt(Bytes bytes, std::size_t at, int depth) {
    if (bytes.size() < kCmptHeaderBytes) return fault("cmpt header is cut short", at + bytes.size());
    if (depth == kMaxCompositeDepth)
      return fault("cmpt nests deeper than " + std::to_string(kMaxCompositeDepth) + " levels", at);
    const auto count = load<std::uint32_t>(bytes, 12);
    std::size_t place = kCmptHeaderBytes;
    for (std::uint32_t i = 0; i < count; ++i) {
      const Bytes rest = bytes.subspan(place);
      const std::uint32_t length = rest.size() < 12 ? 0 : load<std::uint32_t>(rest, 8);
      if (length < 12 || length > rest.size())
        return fault("content " + std::to_string(i) + " of " + std::to_string(count) + " does not fit its cmpt",
                     at + place);
      ZC_TRY(add(rest.first(length), at + place, depth + 1));
      place += length;
    }
    return {};
  }

  const std::string& path_;
  const GltfPlace& place_;
  TextureImages& images_;
  SceneBuilder& builder_;
};

}  // namespace

Status import_tile_content(const std::filesystem::path& file, const GltfPlace& place, TextureImages& images,
                           SceneBuilder& builder) {
  ZC_ASSIGN(const std::vector<std::byte> bytes, read_file(file, kMaxContentBytes));
  const std::string path = file.string();
  builder.enter_file(path);
  return TileContent(path, place, images, builder).add(bytes, 0);
}

}  // namespace zc
