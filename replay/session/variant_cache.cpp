// SPDX-License-Identifier: Apache-2.0
#include "replay/session/variant_cache.h"

#include <stdlib.h>

#include <array>
#include <cstring>
#include <nlohmann/json.hpp>

#include "base/file.h"
#include "shaders/shared/page.h"

namespace zc {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t kFileLimit = 1U << 20U;
constexpr std::size_t kEntryLimit = 64;

std::string page_format() {
  std::array<char, 4> magic;
  std::memcpy(magic.data(), &gpu::kPageMagic, magic.size());
  return {magic.begin(), magic.end()};
}

Json entry_of(const VariantKey& key) {
  return {{"device", key.device}, {"driver", key.driver}, {"zonecast", ZONECAST_VERSION}, {"page", page_format()}};
}

// The entries of a file, whatever they are; none where there is no such file.
Json read_entries(const std::filesystem::path& file) {
  const auto bytes = read_file(file, kFileLimit);
  if (!bytes) return Json::array();
  Json json = Json::parse(reinterpret_cast<const char*>(bytes->data()),
                          reinterpret_cast<const char*>(bytes->data() + bytes->size()), nullptr, false);
  if (!json.is_object() || !json.contains("entries") || !json["entries"].is_array()) return Json::array();
  return std::move(json["entries"]);
}

// What write_cached_variant writes: strings alone, so that nothing in a foreign entry is kept that could be of any
// depth.
bool is_entry(const Json& entry) {
  if (!entry.is_object() || entry.size() != 5) return false;
  for (const char* name : {"device", "driver", "zonecast", "page", "variant"})
    if (!entry.contains(name) || !entry[name].is_string()) return false;
  return true;
}

bool agrees(const Json& entry, const Json& wanted) {
  for (const auto& [name, value] : wanted.items())
    if (entry[name] != value) return false;
  return true;
}

}  // namespace

std::filesystem::path variant_cache_file() {
  for (const auto& [variable, below] : {std::pair{"XDG_CACHE_HOME", "zonecast"}, {"HOME", ".cache/zonecast"}}) {
    const char* folder = ::getenv(variable);
    if (folder != nullptr && std::filesystem::path(folder).is_absolute())
      return std::filesystem::path(folder) / below / "trace_variants.json";
  }
  return {};
}

std::optional<TraceVariant> read_cached_variant(const std::filesystem::path& file, const VariantKey& key) {
  const Json wanted = entry_of(key);
  for (const Json& entry : read_entries(file)) {
    if (!is_entry(entry) || !agrees(entry, wanted)) continue;
    const auto variant = parse_trace_variant(entry["variant"].get_ref<const std::string&>());
    if (variant) return variant;
  }
  return std::nullopt;
}

Status write_cached_variant(const std::filesystem::path& file, const VariantKey& key, const TraceVariant& variant) {
  Json fresh = entry_of(key);
  fresh["variant"] = trace_variant_name(variant);
  Json entries = Json::array({std::move(fresh)});
  for (Json& entry : read_entries(file))
    if (is_entry(entry) && entry["device"] != key.device && entries.size() < kEntryLimit)
      entries.push_back(std::move(entry));
  ZC_TRY(make_folder(file.parent_path()));
  const std::string text =
      Json{{"entries", std::move(entries)}}.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  return write_file(file, std::as_bytes(std::span(text)));
}

}  // namespace zc
