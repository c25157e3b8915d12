// SPDX-License-Identifier: Apache-2.0
// The GPU page: one zone node as the shaders read it, and the only thing that the streamer and the runtime share.
//
//   PageHeader (16 words) | PageNode × node_count (20 words each) | clusters | ClusterEntry × cluster_count | palette
//   | atlas | padding to 4 words
//   cluster: ClusterHeader (8 words) | triangle × triangle_count (1 word each) | vertices, 3 × u16 each | padding to 2
//   words | TriangleLight × triangle_count | TriangleNormals × triangle_count | padding to 4 words
//
// The light, the normals, the appearances and the atlas are there only where the zone needs them.
//
// Nodes are 8 wide. A child's box is 8-bit offsets from the node's origin in steps of 2^e lattice units per axis,
// rounded outwards, after Ylitie, Karras & Laine 2017, "Efficient incoherent ray traversal on GPUs through compressed
// wide BVHs", section 3; origins are integers of the world lattice, so decoding is exact. A page is relocatable: a node
// refers to what belongs to it by the distance in words from its own first word. Top-level nodes have the same form,
// with copies of the pages' roots for leaves, so that a traversal never notices where a page begins. A cluster holds up
// to 256 vertices, 16-bit lattice offsets shared by its triangles: a triangle is three 8-bit vertex numbers and a place
// in the page's palette. Every triangle position of a node's leaves lies in one cluster.
//
// Texture coordinates are not stored: a chart is a flat region seen along one lattice axis, so that two of a point's
// lattice coordinates, scaled and moved as the triangle's Appearance says, are its place in the atlas. The atlas is BC1
// blocks of 4 × 4 texels in rows, level by level, each half as large as the one before; it is read as words like
// everything else, so that it needs no image, no sampler and no format of the device.
#ifndef ZC_SHADERS_SHARED_PAGE_H
#define ZC_SHADERS_SHARED_PAGE_H

#include "shared.h"

ZC_SHARED_BEGIN

ZC_CONST(uint, kPageMagic, 0x3347505Au);  // "ZPG3"
ZC_CONST(uint, kPageHeaderWords, 16u);
ZC_CONST(uint, kPageNodeWords, 20u);
ZC_CONST(uint, kPageTotalWord, 9u);   // where a header has its total_words
ZC_CONST(uint, kPageAtlasWord, 10u);  // and its atlas_offset_words, atlas_size and texels_per_step
ZC_CONST(uint, kClusterHeaderWords, 8u);
ZC_CONST(uint, kClusterEntryWords, 2u);
ZC_CONST(uint, kPageAlignWords, 4u);  // of pages in the pool, and of nodes and clusters in a page: one 16-byte load

ZC_CONST(uint, kNodeWidth, 8u);
ZC_CONST(uint, kLeafMaxTriangles, 8u);   // triangles of one child
ZC_CONST(uint, kNodeMaxTriangles, 32u);  // triangles of all of a node's leaf children
ZC_CONST(uint, kClusterMaxVertices, 256u);
ZC_CONST(uint, kClusterMaxTriangles, 512u);
ZC_CONST(uint, kPoolMaxWords, 1u << 30);  // with the top level: 4 GiB, as shaders count bytes
ZC_CONST(uint, kPaletteMax, 256u);
ZC_CONST(uint, kPageMaxNodes, 0x00FFFFFFu);
ZC_CONST(uint, kPageMaxTriangles, 0x00FFFFFFu);

// Deepest chain of nodes in a page, root counted as 1.
ZC_CONST(uint, kPageMaxDepth, 16u);

// Flags of a page.
ZC_CONST(uint, kPageSplitTriangles, 1u);  // some triangles are in several leaves, each of which holds only a part
ZC_CONST(uint, kPageAppearances, 2u);  // the palette is of Appearances; without it, of 16-bit materials, two to a word
ZC_CONST(uint, kPageLight, 4u);        // its clusters have light
ZC_CONST(uint, kPageNormals, 8u);      // some of its clusters have normals
ZC_CONST(uint, kPageFlags, 15u);       // all there are

// Above a cluster's counts.
ZC_CONST(uint, kClusterVertexBits, 9u);
ZC_CONST(uint, kClusterTriangleBits, 10u);
ZC_CONST(uint, kClusterLight, 1u << 19);
ZC_CONST(uint, kClusterNormals, 1u << 20);
ZC_CONST(uint, kClusterAppearances, 1u << 21);  // as its page
ZC_CONST(uint, kClusterShiftBit, 27u);

// Where an Appearance takes its base colour from.
ZC_CONST(uint, kAppearancePlain, 0u);     // its material
ZC_CONST(uint, kAppearanceColor, 1u);     // itself
ZC_CONST(uint, kAppearanceTextured, 2u);  // the atlas
ZC_CONST(uint, kAtlasMinLog2, 2u);        // of its width and height, at every level: whole blocks
ZC_CONST(uint, kAtlasMaxLog2, 10u);
ZC_CONST(uint, kAtlasMaxLevels, 8u);

struct PageHeader {
  uint magic;
  uint flags;
  uint node_count;      // >= 1; node 0 is the root and lies at kPageHeaderWords
  uint triangle_count;  // >= 1; positions in leaves, in the order of the clusters
  uint cluster_count;
  uint entries_offset_words;  // of the ClusterEntry table
  uint palette_offset_words;  // of the palette
  uint palette_count;
  uint depth;  // nodes on the longest path, <= kPageMaxDepth
  uint total_words;
  uint atlas_offset_words;  // 0: none
  uint atlas_size;          // one byte each: log2 of the width and of the height in texels, levels
  float texels_per_step;    // of the zone's own step
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
  uint counts;           // vertices, triangles, flags and shift; see kClusterVertexBits
  float error_m;         // of the page's zone: see NodeRecord
  uint page_back_words;  // from this header back to the page's first word
  uint first_triangle;   // position of the cluster's first triangle
  uint palette_words;    // from this header to the page's palette
};

struct Appearance {
  uint material;  // 16 bits; from bit 16 what colours it (kAppearance…, 2 bits); from bit 18 the axis that its chart is
                  // seen along (2 bits); from bit 20 log2 of how much wider than the zone's its texels are (3 bits);
                  // from bit 23 by how many 32nds of a power of two texels and colour are too bright (8 bits)
  uint place;  // kAppearanceColor: sRGB, 8 bits each; kAppearanceTextured: added to the texel, u and v, 16 bits each,
               // signed
};

// Baked over the full detail, at the corners of a triangle or for all of it; what no bake knows is white and unshaded.
struct TriangleLight {
  uint sky;     // 8 bits a corner: share of the sky's diffuse light that reaches it; from bit 24 how much the bounced
                // sunlight varies with the sun (8 bits, of 1)
  uint bounce;  // mean colour of what is around (5, 6, 5 bits, linear); from bit 16 mean bounced share of the sun's
                // light (6 bits, of 1); from bit 22 kSun… (2 bits); from bit 24 the sun's direction that bounces most
                // (octahedral, 4 bits each)
};
ZC_CONST(uint, kSunUnknown, 0u);  // for the sun of the bake: partly lit, or nobody looked
ZC_CONST(uint, kSunLit, 1u);      // all of it is lit, or faces away
ZC_CONST(uint, kSunShadow, 2u);   // none of it is

// Unit normals at the corners of a triangle that stands in for a curved surface; 0 in both words: it is flat.
struct TriangleNormals {
  uint first_second;  // octahedral, 10 bits each: x and y of the first corner, x of the second
  uint second_third;  // y of the second, x and y of the third; the two highest bits of either are 0
};

struct ClusterEntry {
  uint first_triangle;
  uint offset_words;  // from the page's first word to the cluster's header
};

#ifdef __cplusplus
#define ZC_INLINE constexpr
#else
#define ZC_INLINE
#endif
// Of ClusterHeader::counts.
ZC_INLINE uint cluster_vertices(uint counts) { return counts & ((1u << kClusterVertexBits) - 1u); }
ZC_INLINE uint cluster_triangles(uint counts) {
  return counts >> kClusterVertexBits & ((1u << kClusterTriangleBits) - 1u);
}
#undef ZC_INLINE

ZC_SHARED_END

#ifdef __cplusplus
static_assert(sizeof(zc::gpu::PageHeader) == 4 * zc::gpu::kPageHeaderWords);
static_assert(offsetof(zc::gpu::PageHeader, total_words) == 4 * zc::gpu::kPageTotalWord);
static_assert(sizeof(zc::gpu::PageNode) == 4 * zc::gpu::kPageNodeWords);
static_assert(sizeof(zc::gpu::ClusterHeader) == 4 * zc::gpu::kClusterHeaderWords);
static_assert(sizeof(zc::gpu::Appearance) == 8);
static_assert(sizeof(zc::gpu::TriangleLight) == 8);
static_assert(sizeof(zc::gpu::TriangleNormals) == 8);
static_assert(offsetof(zc::gpu::PageHeader, atlas_offset_words) == 4 * zc::gpu::kPageAtlasWord);
static_assert(sizeof(zc::gpu::ClusterEntry) == 4 * zc::gpu::kClusterEntryWords);
#endif

#endif
