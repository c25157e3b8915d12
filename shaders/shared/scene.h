// SPDX-License-Identifier: Apache-2.0
// What the shaders know of the resident zones besides their pages: one ZoneEntry a zone, in the order of the pages in
// the pool. It changes with residency, and where a zone begins or ceases to stand in for finer ones. The top-level BVH
// over the zones is made of PageNodes and lies in the pool behind the pages.
#ifndef ZC_SHADERS_SHARED_SCENE_H
#define ZC_SHADERS_SHARED_SCENE_H

#include "shared.h"

ZC_SHARED_BEGIN

ZC_CONST(uint, kZoneCoarse, 1u);  // the zone stands in for finer ones

struct ZoneEntry {
  uint page_word;  // first word of the page in the pool
  uint node;       // index in the world's node table
  uint flags;      // kZone…
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
static_assert(sizeof(zc::gpu::ZoneEntry) == 12);
static_assert(sizeof(zc::gpu::MaterialEntry) == 32);
#endif

#endif
