// SPDX-License-Identifier: Apache-2.0
// What the shaders know of the resident zones besides their pages: one ZoneEntry a zone, in the order of the pages in
// the pool. It is in world lattice units, so moving the camera uploads nothing; it changes only with residency. The
// top-level BVH over the zones is made of PageNodes and lies in the pool behind the pages.
#ifndef ZC_SHADERS_SHARED_SCENE_H
#define ZC_SHADERS_SHARED_SCENE_H

#include "shared.h"

ZC_SHARED_BEGIN

ZC_CONST(uint, kZoneCoarse, 1u);  // the zone stands in for finer ones

struct ZoneEntry {
  int origin_x;  // lattice
  int origin_y;
  int origin_z;
  uint step_shift;
  uint page_word;  // first word of the page in the pool
  uint node;       // index in the world's node table
  float error_m;   // measured two-sided surface distance to the full detail
  uint flags;
};

struct MaterialEntry {
  float base_r;  // linear
  float base_g;
  float base_b;
  float roughness;
  float metallic;
  uint flags;
  uint reserved0;
  uint reserved1;
};

ZC_SHARED_END

#ifdef __cplusplus
static_assert(sizeof(zc::gpu::ZoneEntry) == 32);
static_assert(sizeof(zc::gpu::MaterialEntry) == 32);
#endif

#endif
