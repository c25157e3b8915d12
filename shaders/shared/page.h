// SPDX-License-Identifier: Apache-2.0
// The GPU page: one zone node as the shaders read it, and the only thing that the streamer and the runtime share.
//
//   PageHeader (16 words) | PageNode × node_count (20 words each) | clusters | ClusterEntry × cluster_count | palette
//   cluster: ClusterHeader (8 words) | triangle × triangle_count (1 word each) | vertices, 3 × u16 each | padding to 4
//   words
//
// Nodes are 8 wide. A child's box is 8-bit offsets from the node's origin in steps of 2^e lattice units per axis,
// rounded outwards, after Ylitie, Karras & Laine 2017, "Efficient incoherent ray traversal on GPUs through compressed
// wide BVHs", section 3; origins are integers of the world lattice, so decoding is exact. A page is relocatable: a node
// refers to what belongs to it by the distance in words from its own first word. Top-level nodes have the same form,
// with copies of the pages' roots for leaves, so that a traversal never notices where a page begins. A cluster holds up
// to 256 vertices, 16-bit lattice offsets shared by its triangles: a triangle is three 8-bit vertex numbers and a place
// in the page's material palette. Every triangle position of a node's leaves lies in one cluster.
#ifndef ZC_SHADERS_SHARED_PAGE_H
#define ZC_SHADERS_SHARED_PAGE_H

#include "shared.h"

ZC_SHARED_BEGIN

ZC_CONST(uint, kPageMagic, 0x3247505Au);  // "ZPG2"
ZC_CONST(uint, kPageHeaderWords, 16u);
ZC_CONST(uint, kPageNodeWords, 20u);
ZC_CONST(uint, kPageTotalWord, 9u);  // where a header has its total_words
ZC_CONST(uint, kClusterHeaderWords, 8u);
ZC_CONST(uint, kClusterEntryWords, 2u);
ZC_CONST(uint, kPageAlignWords, 4u);  // of pages in the pool, and of nodes and clusters in a page: one 16-byte load

ZC_CONST(uint, kNodeWidth, 8u);
ZC_CONST(uint, kLeafMaxTriangles, 8u);   // triangles of one child
ZC_CONST(uint, kNodeMaxTriangles, 32u);  // triangles of all of a node's leaf children
ZC_CONST(uint, kClusterMaxVertices, 256u);
ZC_CONST(uint, kClusterMaxTriangles, 512u);
ZC_CONST(uint, kPoolMaxWords, 1u << 25);  // of all pages: a hit numbers triangles within (frame.h)
ZC_CONST(uint, kPaletteMax, 256u);
ZC_CONST(uint, kPageMaxNodes, 0x00FFFFFFu);
ZC_CONST(uint, kPageMaxTriangles, 0x00FFFFFFu);

// Deepest chain of nodes in a page, root counted as 1.
ZC_CONST(uint, kPageMaxDepth, 16u);

ZC_CONST(uint, kPageSplitTriangles, 1u);  // flag: some triangles are in several leaves, each of which holds only a part

struct PageHeader {
  uint magic;
  uint flags;
  uint node_count;      // >= 1; node 0 is the root and lies at kPageHeaderWords
  uint triangle_count;  // >= 1; positions in leaves, in the order of the clusters
  uint cluster_count;
  uint entries_offset_words;  // of the ClusterEntry table
  uint palette_offset_words;  // of the palette: u16 material indices, two to a word
  uint palette_count;
  uint depth;  // nodes on the longest path, <= kPageMaxDepth
  uint total_words;
  uint reserved0;
  uint reserved1;
  uint reserved2;
  uint reserved3;
  uint reserved4;
  uint reserved5;
};

struct PageNode {
  int origin_x;  // world lattice
  int origin_y;
  int origin_z;
  uint exponents_masks;  // 5 bits each: exponent x, y, z; from bit 16: which children are nodes; from 24: which are
                         // leaves
  uint child_offset;     // words to the first child node; the others follow in the order of their slots
  uint triangle_offset;  // words to the first triangle of the leaves; the others follow in the order of their slots
  uint leaf_counts;      // 4 bits a slot: triangles of that leaf
  uint cluster_offset;   // words to the header of the cluster that all those triangles are in
  uint min_x_0;          // one byte a slot, slots 0-3, then 4-7; 255 where there is no child
  uint min_x_4;
  uint min_y_0;
  uint min_y_4;
  uint min_z_0;
  uint min_z_4;
  uint max_x_0;  // 0 where there is no child
  uint max_x_4;
  uint max_y_0;
  uint max_y_4;
  uint max_z_0;
  uint max_z_4;
};

struct ClusterHeader {
  int origin_x;  // world lattice; vertex = origin + (offset << shift)
  int origin_y;
  int origin_z;
  uint counts;           // vertices (9 bits), from bit 9 triangles (18 bits), from bit 27 shift (5 bits)
  float error_m;         // of the page's zone: see NodeRecord
  uint page_back_words;  // from this header back to the page's first word
  uint first_triangle;   // position of the cluster's first triangle
  uint palette_words;    // from this header to the page's palette
};

struct ClusterEntry {
  uint first_triangle;
  uint offset_words;  // from the page's first word to the cluster's header
};

ZC_SHARED_END

#ifdef __cplusplus
static_assert(sizeof(zc::gpu::PageHeader) == 4 * zc::gpu::kPageHeaderWords);
static_assert(offsetof(zc::gpu::PageHeader, total_words) == 4 * zc::gpu::kPageTotalWord);
static_assert(sizeof(zc::gpu::PageNode) == 4 * zc::gpu::kPageNodeWords);
static_assert(sizeof(zc::gpu::ClusterHeader) == 4 * zc::gpu::kClusterHeaderWords);
static_assert(sizeof(zc::gpu::ClusterEntry) == 4 * zc::gpu::kClusterEntryWords);
#endif

#endif
