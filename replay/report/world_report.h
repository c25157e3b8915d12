// SPDX-License-Identifier: Apache-2.0
// What `inspect` reports of a world. Thread-safe: no state.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "streamer/source/source.h"
#include "streamer/world_format/world_index.h"

namespace zc {

// Keys as DESIGN names them for `inspect --json`. bake_s and left_out come from bake.json: absent and empty without it;
// disk_bytes_per_triangle, of the proxies, has the components that bake.json knows, else the kinds of file.
nlohmann::ordered_json describe_world(Source& source, const WorldIndex& index);

// Reads, hashes, decodes and checks every page. What failed, by node.
std::vector<Error> verify_world(Source& source, const WorldIndex& index,
                                const std::function<void(double fraction, std::string_view stage)>& progress);

}  // namespace zc
