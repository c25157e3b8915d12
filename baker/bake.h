// SPDX-License-Identifier: GPL-3.0-or-later
// Bakes a scene into a world directory: snap, repair, drop the interior, cut, simplify, measure, encode, BVH, index,
// tileset. Owns nothing afterwards. Deterministic: the same scene gives the same bytes at any thread count, except for
// bake.json, which holds what this run took.
// Fails when the scene is empty or too wide, or when `out` cannot be replaced; an old world stays as it was.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "baker/bvh/build_wide.h"
#include "baker/proxy/left_out.h"
#include "baker/repair/repair.h"
#include "baker/scene/scene.h"
#include "baker/write/disk_parts.h"
#include "baker/write/world_writer.h"
#include "base/result.h"
#include "streamer/world_format/sun_angles.h"
#include "streamer/world_format/world_index.h"

namespace zc {

inline constexpr const char* kBakeReportName = "bake.json";

struct BakeOptions {
  unsigned threads = 0;                 // 0: all
  std::uint32_t leaf_triangles = 4000;  // of a zone's proxy, and of the root's at most; a zone of more detail is split
  BvhBuildOptions bvh;
  double error_m = 0.10;           // bound of leaf proxies
  std::uint32_t atlas_size = 512;  // of a leaf, texels, a power of two to 1024; halved level by level; 0: none
  bool light = true;               // sky visibility and bounced light, for any sun
  std::optional<SunAngles> sun;    // what it lights and what it does not is stored too
  bool exterior = false;           // faces that nobody outside can see are dropped
  std::int32_t step_log2 = kDefaultStepLog2;
  // Proxies and light of the world that is replaced, where what they were made of is the same; keeps them too.
  bool reuse = true;
  // Called from any thread, one call at a time; fraction in 0..1.
  std::function<void(double fraction, std::string_view stage)> progress;
};

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
};

struct BakeReport {
  WorldIndex index;
  BakeSeconds seconds;
  std::vector<ImportCount> notes;
  RepairReport repair;
  std::uint64_t interior_faces = 0;  // dropped
  std::vector<LeftOut> left_out;
  std::uint64_t proxies_reused = 0;
  std::uint64_t proxies_built = 0;
  std::uint64_t simplify_work = 0;  // boxes and triangles looked at for the proxies that were built
  std::uint64_t lights_reused = 0;  // zones whose light the last bake had
  std::uint64_t lights_built = 0;
  std::uint64_t peak_rss_bytes = 0;  // of the process
  DiskParts proxies;
  DiskParts detail;
};

// writer: opened before the import, so that a place that will not do is known before the work.
Result<BakeReport> bake_world(Scene&& scene, double import_s, const BakeOptions& options, WorldWriter writer);
Result<BakeReport> bake_world(Scene&& scene, double import_s, const BakeOptions& options,
                              const std::filesystem::path& out);

}  // namespace zc
