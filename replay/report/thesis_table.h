// SPDX-License-Identifier: Apache-2.0
// Table 4.1 of the thesis (Fredriksson & Scott 2016), memory of an average zone, beside the same of a world: its leaf
// proxies, the level that the thesis has. Units: bytes, seconds. Thread-safe: no state.
#pragma once

#include <nlohmann/json.hpp>
#include <ostream>

#include "streamer/world_format/world_index.h"

namespace zc {

// {thesis, world}, each {zones, triangles, zone_bytes.{texture, bvh, triangles, normals, uv, light, total},
// bytes_per_triangle (without the texture), bvh_build_s}. bvh_build_s: of all levels; null where no one knows.
nlohmann::ordered_json thesis_table(const WorldIndex& index, const nlohmann::ordered_json& bvh_build_s);

void print_thesis_table(std::ostream& out, const nlohmann::ordered_json& table);

}  // namespace zc
