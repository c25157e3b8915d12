// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/shared/json_text.h"

#include <nlohmann/json.hpp>

namespace zc {
namespace {

// No city model nests deeper than about ten levels; consumers below recurse over free-form members.
constexpr int kMaxDepth = 100;

// Offset of the bracket that nests too deeply, or npos.
std::size_t too_deep(std::string_view text) {
  int depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\')
        ++i;
      else if (c == '"')
        in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '[' || c == '{') {
      if (++depth > kMaxDepth) return i;
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return std::string_view::npos;
}

}  // namespace

std::string one_line(std::string_view text) {
  constexpr std::size_t kLongest = 300;
  std::string line;
  for (const char c : text) {
    const bool blank = static_cast<unsigned char>(c) <= ' ' || c == '\x7F';
    if (!blank)
      line += c;
    else if (!line.empty() && line.back() != ' ')
      line += ' ';
    if (line.size() == kLongest) break;
  }
  while (!line.empty() && (line.back() == ' ' || line.back() == '.')) line.pop_back();
  return line;
}

Result<nlohmann::json> parse_json(std::string_view text, const std::string& path, std::int64_t base_offset) {
  if (const std::size_t at = too_deep(text); at != std::string_view::npos)
    return Error{ErrorCode::kFormat, "JSON nests deeper than " + std::to_string(kMaxDepth) + " levels", path,
                 base_offset + static_cast<std::int64_t>(at)};
  try {
    return nlohmann::json::parse(text);
  } catch (const nlohmann::json::parse_error& fault) {
    // "[json.exception.parse_error.101] parse error at line 1, column 5: cause" -> "cause"
    std::string cause = fault.what();
    if (const std::size_t column = cause.find("column "); column != std::string::npos)
      if (const std::size_t colon = cause.find(": ", column); colon != std::string::npos) cause.erase(0, colon + 2);
    const std::int64_t at = fault.byte > 0 ? static_cast<std::int64_t>(fault.byte) - 1 : 0;
    return Error{ErrorCode::kFormat, "malformed JSON: " + one_line(cause), path, base_offset + at};
  } catch (const nlohmann::json::exception& fault) {  // a number too large; "[json.exception…] cause" -> "cause"
    std::string cause = fault.what();
    if (const std::size_t end = cause.find("] "); end != std::string::npos) cause.erase(0, end + 2);
    return Error{ErrorCode::kFormat, "malformed JSON: " + one_line(cause), path, base_offset};
  }
}

Result<nlohmann::json> parse_small_json(std::string_view text, const std::string& path, std::int64_t base_offset) {
  // What arrays and objects, members and elements take in nlohmann::json, by 64-bit addresses. Marks within strings
  // count too, which the text itself bounds.
  constexpr std::uint64_t kContainerBytes = 80;
  constexpr std::uint64_t kMemberBytes = 96;
  constexpr std::uint64_t kElementBytes = 24;
  std::uint64_t bytes = 0;
  for (const char c : text) {
    if (c == '[' || c == '{') bytes += kContainerBytes;
    if (c == ':') bytes += kMemberBytes;
    if (c == ',') bytes += kElementBytes;
  }
  if (bytes > kMaxSmallJsonBytes)
    return Error{ErrorCode::kUnsupported,
                 "its JSON takes about " + std::to_string(bytes >> 20U) + " MiB of memory, more than the " +
                     std::to_string(kMaxSmallJsonBytes >> 20U) + " allowed; divide it into several files",
                 path};
  return parse_json(text, path, base_offset);
}

bool has_top_level_key(std::string_view text, std::string_view key) {
  int depth = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '[' || c == '{') ++depth;
    if (c == ']' || c == '}') --depth;
    if (c != '"') continue;
    const std::size_t begin = i + 1;
    for (++i; i < text.size() && text[i] != '"'; ++i)
      if (text[i] == '\\') ++i;
    if (depth != 1 || i >= text.size() || text.substr(begin, i - begin) != key) continue;
    const std::size_t after = text.find_first_not_of(" \t\r\n", i + 1);
    if (after != std::string_view::npos && text[after] == ':') return true;
  }
  return false;
}

const nlohmann::json* find_member(const nlohmann::json& object, const char* key) {
  if (!object.is_object()) return nullptr;
  const auto found = object.find(key);
  return found == object.end() || found->is_null() ? nullptr : &*found;
}

std::optional<std::uint64_t> as_unsigned(const nlohmann::json& value) {
  if (!value.is_number_unsigned()) return std::nullopt;
  return value.get<std::uint64_t>();
}

std::optional<std::vector<double>> as_numbers(const nlohmann::json& value, std::size_t count) {
  if (!value.is_array() || value.size() != count) return std::nullopt;
  std::vector<double> numbers;
  for (const nlohmann::json& number : value) {
    if (!number.is_number()) return std::nullopt;
    numbers.push_back(number.get<double>());
  }
  return numbers;
}

}  // namespace zc
