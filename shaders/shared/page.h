// SPDX-License-Identifier: Apache-2.0
// The GPU page: one zone node as the shaders read it, and the only thing that the streamer and the runtime share.
// A page is relocatable: every reference in it is relative to the page's first word.
//
//   PageHeader (8 words) | BvhNode × node_count (8 words each) | PageTriangle × triangle_count (5 words each)
//
// Positions are 16-bit lattice offsets: world lattice position = zone origin + (q << step_shift). Boxes are in the same
// units, so they bound the vertices exactly and cost no second quantisation.
// A node holds its two children's boxes (Aila & Laine 2009, section 4.2 arrange BVH2 nodes likewise, in floats).
// Rays may be traced against pages of any depth up to kPageMaxDepth.
#ifndef ZC_SHADERS_SHARED_PAGE_H
#define ZC_SHADERS_SHARED_PAGE_H

#include "shared.h"

ZC_SHARED_BEGIN

ZC_CONST(uint, kPageMagic, 0x3147505Au);  // "ZPG1"
ZC_CONST(uint, kPageHeaderWords, 8u);
ZC_CONST(uint, kBvhNodeWords, 8u);
ZC_CONST(uint, kPageTriangleWords, 5u);

// Deepest chain of inner nodes in a page, root counted as 1: the traversal stack is sized from it.
ZC_CONST(uint, kPageMaxDepth, 32u);

// child reference: inner = node index; leaf = kRefLeaf | count << 24 | first triangle; absent = kRefNone.
ZC_CONST(uint, kRefLeaf, 0x80000000u);
ZC_CONST(uint, kRefNone, 0xFFFFFFFFu);
ZC_CONST(uint, kRefCountShift, 24u);
ZC_CONST(uint, kRefCountMask, 0x7Fu);
ZC_CONST(uint, kRefFirstMask, 0x00FFFFFFu);
ZC_CONST(uint, kLeafMaxTriangles, 8u);

struct PageHeader {
  uint magic;
  uint node_count;         // >= 1; node 0 is the root
  uint triangle_count;     // >= 1
  uint node_offset_words;  // = kPageHeaderWords
  uint triangle_offset_words;
  uint depth;        // inner nodes on the longest path, <= kPageMaxDepth
  uint total_words;  // whole page
  uint reserved;
};

struct BvhNode {
  uint min0_xy;  // child 0: x | y << 16
  uint min0_z_max0_x;
  uint max0_yz;
  uint min1_xy;  // child 1
  uint min1_z_max1_x;
  uint max1_yz;
  uint ref0;
  uint ref1;
};

struct PageTriangle {
  uint v0_xy;
  uint v0_z_v1_x;
  uint v1_yz;
  uint v2_xy;
  uint v2_z_material;  // z | material index << 16
};

ZC_SHARED_END

#ifdef __cplusplus
static_assert(sizeof(zc::gpu::PageHeader) == 4 * zc::gpu::kPageHeaderWords);
static_assert(sizeof(zc::gpu::BvhNode) == 4 * zc::gpu::kBvhNodeWords);
static_assert(sizeof(zc::gpu::PageTriangle) == 4 * zc::gpu::kPageTriangleWords);
#endif

#endif
