// SPDX-License-Identifier: GPL-3.0-or-later
// `zonecast generate`: a deterministic city with wet streets and glass, so that every claim about reflections can be
// tried without anybody's data. Designed z up, x east, y north, metres, origin in the middle; written y up.
// Units: kilometres for the size, metres inside. Memory: about 60 bytes a triangle. Thread-safe: no state.
// Fails when the size lies outside 0.1..20, when the files cannot be written, or when the GLB would pass 4 GiB.
#pragma once

#include <cstdint>
#include <filesystem>

#include "base/result.h"

namespace zc {

struct GenerateOptions {
  std::uint64_t seed = 1;
  double size_km = 0.5;  // side of the square city; its landmarks take 0.3, a smaller one gets those
};

struct GenerateReport {
  std::uint64_t triangles = 0;
  std::uint64_t objects = 0;
};

// Writes city.glb (a node per object), drive.csv (30 Hz) and shots.json into out_dir, which is made when missing. Same
// options, same bytes.
Result<GenerateReport> generate_city(const GenerateOptions& options, const std::filesystem::path& out_dir);

}  // namespace zc
