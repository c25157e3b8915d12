// SPDX-License-Identifier: Apache-2.0
// What the shaders know of the resident zones besides their pages: one ZoneEntry a zone and the top-level BVH over
// them. Both are in world lattice units, so moving the camera uploads nothing; they change only with residency.
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

// Two children with their boxes, as in a page, but in 32-bit lattice units.
// ref: kRefLeaf | zone slot, an inner node's index, or kRefNone.
struct TopNode {
  int min0_x;
  int min0_y;
  int min0_z;
  int max0_x;
  int max0_y;
  int max0_z;
  int min1_x;
  int min1_y;
  int min1_z;
  int max1_x;
  int max1_y;
  int max1_z;
  uint ref0;
  uint ref1;
  uint reserved0;
  uint reserved1;
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
static_assert(sizeof(zc::gpu::TopNode) == 64);
static_assert(sizeof(zc::gpu::MaterialEntry) == 32);
#endif

#endif
