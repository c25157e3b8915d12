// SPDX-License-Identifier: Apache-2.0
// `.zbvh`: the BVH of one node, built on its decoded Draco mesh, which of that mesh's triangles its leaves contain and
// their appearance; and the page that both make.
//
//   BvhFileHeader | range-coded: tree (tree_code.h), trims, materials or appearances, light, normals
//   (appearance_code.h)
//                 | u32 × atlas words
//
// Appearances, light, normals and atlas are there only where the flags say so. Boxes are not in the file
// (leaf_boxes.h), nor is what the index's record says: counts and depth. Decoded, a node's child_offset is the number
// of its first child node, triangle_offset the position of the first triangle of its leaves and cluster_offset the
// number of their cluster, each 0 where there is none.
//
// Units: steps of the zone, bytes. Thread-safe: plain values and functions without state. Deterministic.
// Untrusted input: decoding compares every count with the index's record before it takes memory, and takes no more than
// NodeRecord::scratch_bytes; nothing is read out of bounds.
// Fails when: a file or a page does not follow its format or its record (kFormat). The encoder only takes sound input.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "shaders/shared/page.h"
#include "streamer/world_format/world_index.h"

namespace zc {

struct BvhFileHeader {
  std::array<char, 4> magic = {'Z', 'B', 'V', '5'};
  std::uint32_t flags = 0;  // as in gpu::PageHeader
  std::uint32_t appearance_count = 0;
  std::uint32_t curved_count = 0;
  std::uint32_t atlas_size = 0;  // as in gpu::PageHeader; 0: none
  float texels_per_step = 0;
};
static_assert(sizeof(BvhFileHeader) == 24);

inline constexpr std::uint32_t kZoneAppearancesMax = 65'536;

// A node's appearance beyond one material a triangle. Every part may be empty.
struct ZoneAppearance {
  std::vector<gpu::Appearance> appearances;
  std::vector<std::uint16_t> appearance_of;   // per decoded triangle; the appearance's material is the triangle's
  std::vector<gpu::TriangleLight> light;      // per decoded triangle
  std::vector<std::uint32_t> curved;          // decoded triangles, ascending
  std::vector<gpu::TriangleNormals> normals;  // of those
  std::uint32_t atlas_size = 0;               // as in gpu::PageHeader
  float texels_per_step = 0;
  std::vector<std::uint32_t> atlas;  // BC1 blocks of all levels

  [[nodiscard]] std::uint32_t page_flags() const {
    return (appearances.empty() ? 0 : gpu::kPageAppearances) | (light.empty() ? 0 : gpu::kPageLight) |
           (curved.empty() ? 0 : gpu::kPageNormals);
  }
};

// How far the box of a leaf with pieces of split triangles ends inside the box of these triangles, in 64ths of its
// extent: x, y and z from below, then from above.
using LeafTrim = std::array<std::uint8_t, 6>;
inline constexpr std::uint32_t kLeafTrimParts = 64;

struct BvhFile {
  bool split = false;  // some triangles are in several leaves
  std::uint32_t depth = 0;
  std::vector<gpu::PageNode> nodes;     // node 0 is the root; children lie behind their parents
  std::vector<std::uint32_t> order;     // by position; with spatial splits a triangle may come several times
  std::vector<std::uint32_t> clusters;  // ascending from 0
  std::vector<LeafTrim> trims;          // by node and slot
  ZoneAppearance appearance;
};

// A node's mesh: 16-bit lattice offsets from the .glb, one material per triangle from the .zbvh.
struct ZoneMesh {
  std::vector<std::array<std::uint16_t, 3>> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint16_t> materials;  // per triangle, index into WorldIndex::materials
};

// Bytes of a `.zbvh` by component; the coded ones to about a byte.
struct BvhFileParts {
  std::uint64_t tree = 0;       // with the trims and the header
  std::uint64_t materials = 0;  // where there are no appearances
  std::uint64_t appearances = 0;
  std::uint64_t light = 0;
  std::uint64_t normals = 0;
  std::uint64_t texture = 0;
};
struct EncodedBvh {
  std::vector<std::byte> bytes;
  BvhFileParts parts;
};

// `mesh` is what decode_zone_glb gives, with materials for the encoder; the decoder gives it those. `node` has the
// tree's counts and depth. Nodes and appearances may come back in another order, the triangles of a leaf do so in the
// mesh's.
EncodedBvh encode_bvh_file(const BvhFile& bvh, const ZoneMesh& mesh, const NodeRecord& node);
Result<BvhFile> decode_bvh_file(std::span<const std::byte> bytes, ZoneMesh& mesh, const NodeRecord& node,
                                const std::string& path);

// Decodes the geometry of a zone .glb (KHR_draco_mesh_compression, u16 POSITION). The triangle order is primitives in
// order, Draco order within. Materials are left empty.
// Fails on anything malformed, never reads out of bounds. Checks counts against `node` before it takes memory.
Result<ZoneMesh> decode_zone_glb(std::span<const std::byte> bytes, const NodeRecord& node, const std::string& path);

// Joins both into the GPU page and checks it. Fails when they do not fit each other or the index's record, and as
// verify_page does. A record's page_bytes of 0, while a bake does not know it yet, fits every page.
Result<std::vector<std::uint32_t>> assemble_page(const ZoneMesh& mesh, const BvhFile& bvh, const NodeRecord& node,
                                                 std::uint32_t material_count, const std::string& path);

// Memory that decoding takes at a time (decode_zone_glb, decode_bvh_file and assemble_page, without the compressed
// bytes and the page itself). A test measures it. The first reads it from the file and is what
// NodeRecord::scratch_bytes stores: decoding refuses a file that asks for more; the second bounds any file of this
// size, for records with scratch_bytes 0. In both is the third, of all that follows decode_zone_glb, with the mesh;
// until a bake knows the record's counts of the BVH it is too little.
std::uint32_t decode_scratch_bytes(std::span<const std::byte> glb, const NodeRecord& node);
std::uint32_t decode_scratch_bound(const NodeRecord& node, std::uint64_t glb_bytes);
std::uint32_t page_scratch_bytes(const NodeRecord& node, std::uint64_t vertex_count);

// The check alone, for pages from anywhere, in one linear pass: every reference in range, every node and triangle
// position reached once, depth, every box contains its children and triangles, materials in range. After it, a
// traversal with a stack for the page's depth stays in the page and ends.
Status verify_page(std::span<const std::uint32_t> page, std::uint32_t material_count, const std::string& path);

}  // namespace zc
