// SPDX-License-Identifier: GPL-3.0-or-later
// Writes every node's `.glb` and reads it back as the streamer reads it: whatever follows belongs to the decoded mesh.
// Deterministic at any thread count. Fails as encode_zone_glb and writing do.
#pragma once

#include <span>
#include <vector>

#include "baker/proxy/proxy_tree.h"
#include "baker/scene/bake_context.h"
#include "baker/write/disk_parts.h"
#include "baker/write/world_writer.h"
#include "streamer/world_format/bvh_page.h"

namespace zc {

struct EncodeInput {
  std::vector<ProxyNode> nodes;
  double step_m = 0;
  WorldWriter& writer;
  // Of the whole city:
  std::span<const Material> materials;
};

struct EncodedNodes {                   // all per node
  decltype(WorldIndex::nodes) records;  // as far as the mesh goes
  std::vector<ZoneMesh> meshes;
  std::vector<DiskParts> disk;
};

Result<EncodedNodes> encode_nodes(EncodeInput&& input, BakeContext& context);

}  // namespace zc
