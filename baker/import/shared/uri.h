// SPDX-License-Identifier: GPL-3.0-or-later
// The files that a model is made of, by the relative paths or URIs (RFC 3986) that it names them by: none lies outside
// the folder of the input. Names alone are compared: links are followed where they lead. Untrusted input. Thread-safe:
// no state.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "base/result.h"

namespace zc {

// As lexically_normal(); the two slashes of a web address (http://) stay.
std::filesystem::path normal_path(const std::filesystem::path& path);

// The folder that an input's files lie in, "." for a bare name.
std::filesystem::path folder_of(const std::filesystem::path& input);

// The file that the model `from` calls `name`, a path. Fails on absolute paths and on those that lead out of `root`.
Result<std::filesystem::path> file_of_name(const std::string& name, const std::filesystem::path& from,
                                           const std::filesystem::path& root);

// Likewise by a URI, without its query and fragment. Fails too on schemes and on separators written as %2F.
Result<std::filesystem::path> file_of_uri(std::string_view uri, const std::filesystem::path& from,
                                          const std::filesystem::path& root);

}  // namespace zc
