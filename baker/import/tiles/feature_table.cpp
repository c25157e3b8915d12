// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/tiles/feature_table.h"

#include <string_view>

#include "baker/import/shared/json_text.h"

namespace zc {
namespace {

using nlohmann::json;
using Bytes = std::span<const std::byte>;

std::optional<std::uint64_t> offset_of(const json& value) {
  const json* offset = find_member(value, "byteOffset");
  return offset != nullptr ? as_unsigned(*offset) : std::nullopt;
}

}  // namespace

Result<FeatureTable> FeatureTable::read(Bytes table, Bytes binary, const std::string& path, std::size_t at) {
  std::string_view text(reinterpret_cast<const char*>(table.data()), table.size());
  text.remove_suffix(text.size() - (text.find_last_not_of(std::string_view(" \t\r\n\0", 5)) + 1));
  if (text.empty()) return FeatureTable(json::object(), binary, path, at);
  ZC_ASSIGN(json values, parse_small_json(text, path, static_cast<std::int64_t>(at)));
  return FeatureTable(std::move(values), binary, path, at);
}

Result<Bytes> FeatureTable::bytes_at(const char* name, std::uint64_t offset, std::uint64_t bytes) const {
  if (offset > binary_.size() || bytes > binary_.size() - offset)
    return error(std::string(name) + " reaches past the " + std::to_string(binary_.size()) +
                 " bytes of the feature table");
  return binary_.subspan(offset, bytes);
}

Result<std::optional<glm::dvec3>> FeatureTable::vector(const char* name) const {
  const json* value = find_member(values_, name);
  if (value == nullptr) return std::optional<glm::dvec3>();
  if (const auto numbers = as_numbers(*value, 3))
    return std::optional(glm::dvec3((*numbers)[0], (*numbers)[1], (*numbers)[2]));
  const auto offset = offset_of(*value);
  if (!offset) return error(std::string(name) + " is neither three numbers nor a byteOffset");
  ZC_ASSIGN(const Bytes bytes, bytes_at(name, *offset, 12));
  return std::optional(
      glm::dvec3(load_number<float>(bytes, 0), load_number<float>(bytes, 4), load_number<float>(bytes, 8)));
}

Result<std::optional<std::uint64_t>> FeatureTable::number(const char* name) const {
  const json* value = find_member(values_, name);
  if (value == nullptr) return std::optional<std::uint64_t>();
  if (const auto plain = as_unsigned(*value)) return plain;
  const auto offset = offset_of(*value);
  if (!offset) return error(std::string(name) + " is neither a whole number nor a byteOffset");
  ZC_ASSIGN(const Bytes bytes, bytes_at(name, *offset, 4));
  return std::optional<std::uint64_t>(load_number<std::uint32_t>(bytes, 0));
}

Result<std::optional<Bytes>> FeatureTable::elements(const char* name, std::uint64_t count,
                                                    std::size_t element_bytes) const {
  const json* value = find_member(values_, name);
  if (value == nullptr) return std::optional<Bytes>();
  const auto offset = offset_of(*value);
  if (!offset) return error(std::string(name) + " has no byteOffset");
  if (count > binary_.size()) return bytes_at(name, *offset, UINT64_MAX).error();
  ZC_ASSIGN(const Bytes bytes, bytes_at(name, *offset, count * element_bytes));
  return std::optional(bytes);
}

bool FeatureTable::is_true(const char* name) const {
  const json* value = find_member(values_, name);
  return value != nullptr && value->is_boolean() && value->get<bool>();
}

}  // namespace zc
