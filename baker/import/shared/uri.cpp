// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/shared/uri.h"

#include <algorithm>
#include <cctype>

#include "baker/import/shared/json_text.h"

namespace zc {
namespace {

// "http:", "file:", "data:"; a colon behind a slash is part of a name.
bool has_scheme(std::string_view uri) {
  const std::size_t colon = uri.find_first_of(":/");
  if (colon == std::string_view::npos || uri[colon] != ':' || colon == 0) return false;
  return std::all_of(uri.begin(), uri.begin() + static_cast<std::ptrdiff_t>(colon),
                     [](unsigned char c) { return std::isalnum(c) != 0 || c == '+' || c == '-' || c == '.'; });
}

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

Error refused(std::string_view name, const char* cause, const std::filesystem::path& from) {
  return {ErrorCode::kUnsupported, "'" + one_line(name) + "' " + cause, from.string()};
}

}  // namespace

std::filesystem::path normal_path(const std::filesystem::path& path) {
  std::string text = path.lexically_normal().string();
  for (const std::string_view scheme : {"http:/", "https:/"})
    if (path.native().starts_with(std::string(scheme) + "/")) text.insert(scheme.size(), 1, '/');
  return text;
}

std::filesystem::path folder_of(const std::filesystem::path& input) {
  return input.has_parent_path() ? input.parent_path() : ".";
}

Result<std::filesystem::path> file_of_name(const std::string& name, const std::filesystem::path& from,
                                           const std::filesystem::path& root) {
  const std::filesystem::path path = name;
  if (name.empty() || name.find('\0') != std::string::npos) return refused(name, "names no file", from);
  if (path.is_absolute()) return refused(name, "is an absolute path: only relative ones are read", from);
  const std::filesystem::path file = normal_path(from.parent_path() / path);
  const std::filesystem::path inside = file.lexically_relative(root.lexically_normal());
  if (inside.empty() || *inside.begin() == "..") return refused(name, "leads out of the folder of the input", from);
  return file;
}

Result<std::filesystem::path> file_of_uri(std::string_view uri, const std::filesystem::path& from,
                                          const std::filesystem::path& root) {
  if (has_scheme(uri)) return refused(uri, "is no file beside the model: only relative URIs are read", from);
  const std::string_view path = uri.substr(0, uri.find_first_of("?#"));
  const std::string name = percent_decoded(path);
  if (std::count(name.begin(), name.end(), '/') != std::count(path.begin(), path.end(), '/'))
    return refused(uri, "hides a separator", from);
  return file_of_name(name, from, root);
}

}  // namespace zc
