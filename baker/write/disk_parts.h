// SPDX-License-Identifier: GPL-3.0-or-later
// What a world's zones take on the disk, by component. Units: bytes. Plain values.
#pragma once

#include <cstdint>

#include "streamer/world_format/bvh_page.h"

namespace zc {

struct DiskParts {
  std::uint64_t triangles = 0;
  std::uint64_t mesh = 0;  // Draco: connectivity and positions
  std::uint64_t json = 0;  // of the .glb, with its frame
  BvhFileParts bvh;

  void add(const DiskParts& more) {
    triangles += more.triangles;
    mesh += more.mesh;
    json += more.json;
    bvh.tree += more.bvh.tree;
    bvh.materials += more.bvh.materials;
    bvh.appearances += more.bvh.appearances;
    bvh.light += more.bvh.light;
    bvh.normals += more.bvh.normals;
    bvh.texture += more.bvh.texture;
  }
};

}  // namespace zc
