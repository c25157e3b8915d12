// SPDX-License-Identifier: GPL-3.0-or-later
// The files of a tileset on a web server, http or https. Requests that fail for now are repeated. Untrusted input:
// sizes are bounded. Not thread-safe.
#pragma once

#include <memory>
#include <string>

#include "baker/import/shared/input_files.h"

namespace zc {

struct WebTileset {
  std::unique_ptr<InputFiles> files;
  std::filesystem::path path;  // of the tileset: its address without credentials and query
};

// What `url` adds for access, credentials and query, goes with every request below its folder. Asks for nothing.
Result<WebTileset> open_web_files(const std::string& url);

}  // namespace zc
