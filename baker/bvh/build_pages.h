// SPDX-License-Identifier: GPL-3.0-or-later
// Writes every node's `.zbvh` and reads it back as the streamer reads it: the page must be the one that it was made
// from. Deterministic at any thread count. Fails as build_page and writing do.
#pragma once

#include <cstdint>
#include <vector>

#include "baker/bvh/build_wide.h"
#include "baker/scene/bake_context.h"
#include "baker/write/disk_parts.h"
#include "baker/write/world_writer.h"
#include "streamer/world_format/bvh_page.h"

namespace zc {

struct PagesInput {  // all per node
  decltype(WorldIndex::nodes) records;
  std::vector<ZoneMesh> meshes;
  std::vector<ZoneAppearance> appearances;  // with the light
  std::vector<DiskParts> disk;
  BvhBuildOptions options;
  const WorldWriter& writer;
  // Of the whole city:
  std::uint32_t material_count = 0;
};

struct Pages {                          // all per node
  decltype(WorldIndex::nodes) records;  // complete
  std::vector<DiskParts> disk;
};

Result<Pages> build_pages(PagesInput&& input, BakeContext& context);

}  // namespace zc
