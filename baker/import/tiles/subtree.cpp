// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/tiles/subtree.h"

#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "baker/import/shared/json_text.h"
#include "baker/import/shared/uri.h"

namespace zc {
namespace {

using nlohmann::json;
using Bytes = std::span<const std::byte>;

constexpr std::size_t kHeaderBytes = 24;  // magic, version, then the lengths of JSON and binary in 8 bytes each
constexpr std::uint64_t kMaxBufferBytes = std::uint64_t{1} << 28U;

class SubtreeReader {
 public:
  SubtreeReader(const std::filesystem::path& path, const std::filesystem::path& root, TileFiles& files)
      : path_(path), root_(root), files_(files) {}

  Result<std::optional<Subtree>> run(Bytes bytes, const ImplicitTiling& tiling) {
    std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (text.starts_with("subt")) {
      if (bytes.size() < kHeaderBytes) return error("subtree header is cut short: get the file again");
      std::uint32_t version = 0;
      std::uint64_t json_bytes = 0;
      std::uint64_t binary_bytes = 0;
      std::memcpy(&version, bytes.data() + 4, sizeof version);
      std::memcpy(&json_bytes, bytes.data() + 8, sizeof json_bytes);
      std::memcpy(&binary_bytes, bytes.data() + 16, sizeof binary_bytes);
      if (version != 1) return error("subtree version " + std::to_string(version) + ", only 1 is read");
      const std::uint64_t rest = bytes.size() - kHeaderBytes;
      if (json_bytes > rest || binary_bytes > rest - json_bytes)
        return error("subtree declares " + std::to_string(json_bytes) + " and " + std::to_string(binary_bytes) +
                     " bytes and has " + std::to_string(rest) + ": get the file again");
      text = text.substr(kHeaderBytes, json_bytes);
      binary_ = bytes.subspan(kHeaderBytes + json_bytes, binary_bytes);
      at_ = kHeaderBytes;
    }
    ZC_ASSIGN(document_, parse_small_json(text, path_.string(), at_));
    if (!document_.is_object()) return error("is no subtree: expected a JSON object or the letters subt");
    const std::uint64_t last_level = power(tiling.branching, tiling.subtree_levels);
    const std::uint64_t tiles = (last_level - 1) / (tiling.branching - 1);
    Subtree subtree;
    const json* available = find_member(document_, "tileAvailability");
    if (available == nullptr) return error("subtree has no tileAvailability");
    ZC_ASSIGN(auto of_tiles, availability(*available, tiles, "tileAvailability"));
    const json* children = find_member(document_, "childSubtreeAvailability");
    if (children == nullptr) return error("subtree has no childSubtreeAvailability");
    ZC_ASSIGN(auto of_children, availability(*children, last_level, "childSubtreeAvailability"));
    bool is_whole = of_tiles && of_children;
    if (is_whole) {
      subtree.tiles = *std::move(of_tiles);
      subtree.child_subtrees = *std::move(of_children);
    }
    for (const json* content : all_of(document_, "contentAvailability", "contentAvailability")) {
      ZC_ASSIGN(auto of_content, availability(*content, tiles, "contentAvailability"));
      is_whole = is_whole && of_content;
      if (is_whole) subtree.contents.push_back(*std::move(of_content));
    }
    if (!is_whole) return std::optional<Subtree>();
    return std::optional(std::move(subtree));
  }

 private:
  [[nodiscard]] Error error(std::string message) const {
    return {ErrorCode::kFormat, std::move(message), path_.string()};
  }

  static std::uint64_t power(std::uint64_t base, std::uint32_t exponent) {
    std::uint64_t value = 1;
    for (std::uint32_t i = 0; i < exponent; ++i) value *= base;
    return value;
  }

  // Nothing when its buffer is not there and may be skipped.
  Result<std::optional<Availability>> availability(const json& available, std::uint64_t count,
                                                   const std::string& where) {
    if (const json* constant = find_member(available, "constant"); constant != nullptr) {
      const auto value = as_unsigned(*constant);
      if (!value || *value > 1) return error(where + " has a constant that is neither 0 nor 1");
      return std::optional(Availability(*value == 1));
    }
    const json* bitstream = find_member(available, "bitstream");
    if (bitstream == nullptr) bitstream = find_member(available, "bufferView");  // as drafts of the extension have it
    const auto view = bitstream != nullptr ? as_unsigned(*bitstream) : std::nullopt;
    if (!view) return error(where + " has neither a constant nor a bitstream");
    ZC_ASSIGN(const std::optional<Bytes> bits, view_of(*view, where));
    if (!bits) return std::optional<Availability>();
    const std::uint64_t needed = (count + 7) / 8;
    if (bits->size() < needed)
      return error(where + " has " + std::to_string(bits->size()) + " bytes, expected " + std::to_string(needed) +
                   " for " + std::to_string(count) + " bits");
    return std::optional(
        Availability(std::vector<std::byte>(bits->begin(), bits->begin() + static_cast<std::ptrdiff_t>(needed))));
  }

  [[nodiscard]] const json* element(const char* list, std::uint64_t index) const {
    const json* all = find_member(document_, list);
    return all != nullptr && all->is_array() && index < all->size() ? &(*all)[index] : nullptr;
  }
  static std::optional<std::uint64_t> number(const json& object, const char* key) {
    const json* member = find_member(object, key);
    return member != nullptr ? as_unsigned(*member) : std::nullopt;
  }

  Result<std::optional<Bytes>> view_of(std::uint64_t index, const std::string& where) {
    const json* view = element("bufferViews", index);
    const auto buffer = view != nullptr ? number(*view, "buffer") : std::nullopt;
    const auto length = view != nullptr ? number(*view, "byteLength") : std::nullopt;
    if (!buffer || !length)
      return error(where + " names bufferView " + std::to_string(index) + ", which is not there or not whole");
    ZC_ASSIGN(const std::optional<Bytes> bytes, buffer_of(*buffer));
    if (!bytes) return std::optional<Bytes>();
    const std::uint64_t offset = number(*view, "byteOffset").value_or(0);
    if (offset > bytes->size() || *length > bytes->size() - offset)
      return error("bufferView " + std::to_string(index) + " reaches past the " + std::to_string(bytes->size()) +
                   " bytes of buffer " + std::to_string(*buffer));
    return std::optional(bytes->subspan(offset, *length));
  }

  Result<std::optional<Bytes>> buffer_of(std::uint64_t index) {
    const json* buffer = element("buffers", index);
    const auto length = buffer != nullptr ? number(*buffer, "byteLength") : std::nullopt;
    if (!length) return error("buffer " + std::to_string(index) + " is not there or has no byteLength");
    Bytes bytes = binary_;
    if (const json* uri = find_member(*buffer, "uri"); uri != nullptr) {
      if (!uri->is_string()) return error("buffer " + std::to_string(index) + " has a uri that is not text");
      const auto [slot, is_new] = loaded_.try_emplace(index);
      if (is_new) {
        ZC_ASSIGN(const std::filesystem::path file, file_of_uri(uri->get<std::string>(), path_, root_));
        ZC_ASSIGN(slot->second, files_.read(file, kMaxBufferBytes));
      }
      if (!slot->second) return std::optional<Bytes>();
      bytes = *slot->second;
    }
    if (*length > bytes.size())
      return error("buffer " + std::to_string(index) + " declares " + std::to_string(*length) + " bytes, " +
                   std::to_string(bytes.size()) + " exist");
    return std::optional(bytes.first(*length));
  }

  const std::filesystem::path& path_;
  const std::filesystem::path& root_;
  TileFiles& files_;
  json document_;
  Bytes binary_;
  std::int64_t at_ = 0;                                                    // of the JSON in the file
  std::map<std::uint64_t, std::optional<std::vector<std::byte>>> loaded_;  // buffers in files of their own
};

}  // namespace

std::string fill_template(std::string_view uri, const TileAddress& tile) {
  std::string filled;
  const std::pair<std::string_view, std::uint32_t> variables[] = {
      {"{level}", tile.level}, {"{x}", tile.x}, {"{y}", tile.y}, {"{z}", tile.z}};
  while (!uri.empty()) {
    bool is_variable = false;
    for (const auto& [name, value] : variables) {
      if (!uri.starts_with(name)) continue;
      filled += std::to_string(value);
      uri.remove_prefix(name.size());
      is_variable = true;
      break;
    }
    if (is_variable) continue;
    filled += uri.front();
    uri.remove_prefix(1);
  }
  return filled;
}

Result<std::optional<Subtree>> read_subtree(std::span<const std::byte> bytes, const std::filesystem::path& path,
                                            const std::filesystem::path& root, const ImplicitTiling& tiling,
                                            TileFiles& files) {
  return SubtreeReader(path, root, files).run(bytes, tiling);
}

}  // namespace zc
