// SPDX-License-Identifier: Apache-2.0
// `.zbvh`: the BVH of one node, built on its decoded Draco mesh, which of that mesh's triangles its leaves hold and how
// they look; and the page that both make.
//
//   BvhFileHeader | gpu::PageNode × node_count | u32 × reference_count (page position -> decoded triangle)
//                 | u32 × cluster_count (each cluster's first position)
//                 | gpu::Look × look_count, u16 × triangle_count (decoded triangle -> look), padding to 4 bytes
//                 | gpu::TriangleLight × triangle_count
//                 | u32 × curved_count (decoded triangles, ascending), gpu::TriangleNormals × curved_count
//                 | u32 × atlas words
//
// From the looks on, a part is there only where the flags say so.
// In the file a node's child_offset is the number of its first child node, triangle_offset the position of the first
// triangle of its leaves and cluster_offset the number of their cluster, each 0 where there is none.
//
// Untrusted input. Thread-safe: plain values.
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
  std::array<char, 4> magic = {'Z', 'B', 'V', '3'};
  std::uint32_t flags = 0;  // as in gpu::PageHeader
  std::uint32_t node_count = 0;
  std::uint32_t reference_count = 0;
  std::uint32_t cluster_count = 0;
  std::uint32_t depth = 0;
  std::uint32_t triangle_count = 0;
  std::uint32_t look_count = 0;
  std::uint32_t curved_count = 0;
  std::uint32_t atlas_size = 0;  // as in gpu::PageHeader; 0: none
  float texels_per_step = 0;
  std::uint32_t reserved = 0;
};
static_assert(sizeof(BvhFileHeader) == 48);

inline constexpr std::uint32_t kZoneLooksMax = 65'536;

// How a node's surface looks beyond one material a triangle. Every part may be empty.
struct ZoneAppearance {
  std::vector<gpu::Look> looks;
  std::vector<std::uint16_t> look_of;         // per decoded triangle; the look's material is the triangle's
  std::vector<gpu::TriangleLight> light;      // per decoded triangle
  std::vector<std::uint32_t> curved;          // decoded triangles, ascending
  std::vector<gpu::TriangleNormals> normals;  // of those
  std::uint32_t atlas_size = 0;               // as in gpu::PageHeader
  float texels_per_step = 0;
  std::vector<std::uint32_t> atlas;  // BC1 blocks of all levels

  [[nodiscard]] std::uint32_t page_flags() const {
    return (looks.empty() ? 0 : gpu::kPageLooks) | (light.empty() ? 0 : gpu::kPageLight) |
           (curved.empty() ? 0 : gpu::kPageNormals);
  }
};

struct BvhFile {
  bool split = false;  // some triangles are in several leaves
  std::uint32_t depth = 0;
  std::vector<gpu::PageNode> nodes;     // node 0 is the root; children lie behind their parents
  std::vector<std::uint32_t> order;     // by position; with spatial splits a triangle may come several times
  std::vector<std::uint32_t> clusters;  // ascending from 0
  ZoneAppearance appearance;
};

std::vector<std::byte> encode_bvh_file(const BvhFile& bvh);
Result<BvhFile> decode_bvh_file(std::span<const std::byte> bytes, const std::string& path);

// A node's mesh as its .glb stores it: 16-bit lattice offsets, one material per triangle.
struct ZoneMesh {
  std::vector<std::array<std::uint16_t, 3>> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint16_t> materials;  // per triangle, index into WorldIndex::materials
};

// Decodes the geometry of a zone .glb (KHR_draco_mesh_compression, u16 POSITION; each primitive's material index is
// `extras.zonecast_material` of its glTF material). The triangle order is primitives in order, Draco order within.
// Fails on anything malformed, never reads out of bounds. Checks counts against `node` before it takes memory.
Result<ZoneMesh> decode_zone_glb(std::span<const std::byte> bytes, const NodeRecord& node, const std::string& path);

// Joins both into the GPU page and checks it. Fails when they do not fit each other or the index's record, and as
// verify_page does. A record's page_bytes of 0, while a bake does not know it yet, fits every page.
Result<std::vector<std::uint32_t>> assemble_page(const ZoneMesh& mesh, const BvhFile& bvh, const NodeRecord& node,
                                                 std::uint32_t material_count, const std::string& path);

// Memory that decoding takes (decode_zone_glb, decode_bvh_file and assemble_page, without the compressed bytes and the
// page itself). A test measures it. The first reads it from the file and is what NodeRecord::scratch_bytes holds:
// decoding refuses a file that asks for more; the second holds for any file of this size, for records with
// scratch_bytes 0.
std::uint32_t decode_scratch_bytes(std::span<const std::byte> glb, const NodeRecord& node);
std::uint32_t decode_scratch_bound(const NodeRecord& node, std::uint64_t glb_bytes);

// The part of both that goes by bvh_bytes and reference_count; 0 while a bake does not know them.
std::uint32_t bvh_scratch_bytes(const NodeRecord& node);

// The check alone, for pages from anywhere, in one linear pass: every reference in range, every node and triangle
// position reached once, depth, every box contains its children and triangles, materials in range. After it, a
// traversal with a stack for the page's depth stays in the page and ends.
Status verify_page(std::span<const std::uint32_t> page, std::uint32_t material_count, const std::string& path);

}  // namespace zc
