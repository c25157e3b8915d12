// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/uri.h"

#include <algorithm>
#include <cctype>

#include "baker/import/json_text.h"

namespace zc {
namespace {

// "http:", "file:", "data:"; a colon behind a slash is part of a name.
bool has_scheme(std::string_view uri) {
  const std::size_t colon = uri.find_first_of(":/");
  if (colon == std::string_view::npos || uri[colon] != ':' || colon == 0) return false;
  return std::all_of(uri.begin(), uri.begin() + static_cast<std::ptrdiff_t>(colon),
                     [](unsigned char c) { return std::isalnum(c) != 0 || c == '+' || c == '-' || c == '.'; });
}

}  // namespace

std::string percent_decoded(std::string_view uri) {
  const auto digit = [](char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
  };
  std::string text;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] == '%' && i + 2 < uri.size() && digit(uri[i + 1]) >= 0 && digit(uri[i + 2]) >= 0) {
      text += static_cast<char>(digit(uri[i + 1]) * 16 + digit(uri[i + 2]));
      i += 2;
    } else {
      text += uri[i];
    }
  }
  return text;
}

Result<std::filesystem::path> file_of_uri(std::string_view uri, const std::filesystem::path& from,
                                          const std::filesystem::path& root) {
  const auto refused = [&](const char* cause) {
    return Error{ErrorCode::kUnsupported, "'" + one_line(uri) + "' " + cause, from.string()};
  };
  if (has_scheme(uri)) return refused("is no file beside the model: only relative URIs are read");
  const std::filesystem::path name = percent_decoded(uri.substr(0, uri.find_first_of("?#")));
  if (name.empty() || name.native().find('\0') != std::string::npos) return refused("names no file");
  if (name.is_absolute()) return refused("is an absolute path: only relative URIs are read");
  const std::filesystem::path file = (from.parent_path() / name).lexically_normal();
  const std::filesystem::path inside = file.lexically_relative(root.lexically_normal());
  if (inside.empty() || *inside.begin() == "..") return refused("leads out of the folder of the input");
  return file;
}

}  // namespace zc
