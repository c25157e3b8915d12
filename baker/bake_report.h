// SPDX-License-Identifier: GPL-3.0-or-later
// What a bake did and took, and bake.json, which keeps that in the world. Plain values.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "baker/repair/repair.h"
#include "baker/scene/bake_context.h"
#include "baker/scene/scene.h"
#include "baker/write/disk_parts.h"
#include "baker/write/left_out.h"
#include "streamer/world_format/world_index.h"

namespace zc {

inline constexpr const char* kBakeReportName = "bake.json";
// As `replay` has it by default (ReflectionOptions::roughness_cut).
inline constexpr float kReflectingRoughness = 0.35F;

struct BakeOptions;

struct BakeSeconds {  // wall clock
  double total = 0;
  double import_s = 0;
  double repair = 0;  // with the snap
  double exterior = 0;
  double cut = 0;
  double simplify = 0;  // with the measuring of errors
  double light = 0;
  double encode = 0;
  double atlas = 0;
  double bvh = 0;

  static BakeSeconds of(const BakeContext& context, double import_s);
};

struct BakeReport {
  WorldIndex index;
  BakeSeconds seconds;
  double reflecting_share = 0;  // of the input's surface: smoother than kReflectingRoughness
  std::vector<ImportCount> notes;
  RepairReport repair;
  std::uint64_t interior_faces = 0;  // dropped
  std::vector<LeftOut> left_out;
  std::uint64_t proxies_reused = 0;
  std::uint64_t proxies_built = 0;
  std::uint64_t simplify_work = 0;  // boxes and triangles visited for the proxies that were built
  std::uint64_t lights_reused = 0;  // zones whose light the last bake had
  std::uint64_t lights_built = 0;
  std::uint64_t peak_rss_bytes = 0;  // of the process
  DiskParts proxies;
  DiskParts detail;
};

std::string bake_json(const BakeReport& report, const BakeOptions& options);

}  // namespace zc
