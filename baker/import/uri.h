// SPDX-License-Identifier: GPL-3.0-or-later
// Relative URIs (RFC 3986) by which models name the files that they are made of. Untrusted input.
// Thread-safe: no state.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "base/result.h"

namespace zc {

std::string percent_decoded(std::string_view uri);

// The file that `uri`, found in the file `from`, names; its query and fragment are dropped. Compares names alone: links
// are followed where they lead. Fails on schemes, on absolute paths and on paths that lead out of the folder `root`.
Result<std::filesystem::path> file_of_uri(std::string_view uri, const std::filesystem::path& from,
                                          const std::filesystem::path& root);

}  // namespace zc
