// SPDX-License-Identifier: GPL-3.0-or-later
// What a bake leaves out because it would change nothing, and what that saves: bytes of pages, and of files where they
// are known, over all nodes. Of faces and levels, which are never encoded, the bytes follow from what others of their
// kind take for a triangle. Plain values.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "baker/write/disk_parts.h"
#include "streamer/world_format/world_index.h"

namespace zc {

struct LeftOut {
  std::string what;  // of the plural that is counted
  std::uint64_t count = 0;
  std::uint64_t page_bytes = 0;
  std::uint64_t disk_bytes = 0;  // 0: not known
};

struct LeftOutInput {
  std::uint64_t interior_faces = 0;
  std::uint64_t levels = 0;                // zones whose proxy is not worth storing
  std::uint64_t level_triangles = 0;       // that these would have at least
  bool light = false;                      // was baked
  std::vector<std::uint32_t> atlas_sizes;  // per node, texels a side that it may have at most; empty: no atlases
};

// Nothing of which there is none.
std::vector<LeftOut> count_left_out(const WorldIndex& index, const DiskParts& proxies, const DiskParts& detail,
                                    const LeftOutInput& input);

}  // namespace zc
