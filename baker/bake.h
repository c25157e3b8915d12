// SPDX-License-Identifier: GPL-3.0-or-later
// Bakes a scene into a world directory, stage by stage (bake.cpp). Owns nothing afterwards. Deterministic: the same
// scene gives the same bytes at any thread count, except for bake.json, which contains what this run took.
// Fails when the scene is empty or too wide, or when `out` cannot be replaced; an old world stays as it was.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "baker/bake_report.h"
#include "baker/bvh/build_wide.h"
#include "baker/scene/bake_context.h"
#include "baker/scene/bake_origin.h"
#include "baker/scene/scene.h"
#include "baker/write/world_writer.h"
#include "base/result.h"
#include "streamer/world_format/sun_angles.h"

namespace zc {

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
  BakeOrigin origin;  // for bake.json
  BakeContext::Report progress;
};

// writer: opened before the import, so that a place that will not do is known before the work.
Result<BakeReport> bake_world(Scene&& scene, double import_s, const BakeOptions& options, WorldWriter writer);
Result<BakeReport> bake_world(Scene&& scene, double import_s, const BakeOptions& options,
                              const std::filesystem::path& out);

}  // namespace zc
