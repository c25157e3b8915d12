// SPDX-License-Identifier: Apache-2.0
// `.zbvh`: the BVH of one node, built on its decoded Draco mesh, and the order of that mesh's triangles in the leaves.
//
//   BvhFileHeader | gpu::BvhNode × node_count | u32 × triangle_count (page position -> decoded triangle)
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
  std::array<char, 4> magic = {'Z', 'B', 'V', '1'};
  std::uint32_t node_count = 0;
  std::uint32_t triangle_count = 0;
  std::uint32_t depth = 0;
};
static_assert(sizeof(BvhFileHeader) == 16);

struct BvhFile {
  std::uint32_t depth = 0;
  std::vector<gpu::BvhNode> nodes;
  std::vector<std::uint32_t> order;
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

// Joins both into the GPU page and checks it in one linear pass: every reference in range, depth, every box contains
// its children and triangles, each triangle in exactly one leaf, materials in range.
Result<std::vector<std::uint32_t>> assemble_page(const ZoneMesh& mesh, const BvhFile& bvh, const NodeRecord& node,
                                                 std::uint32_t material_count, const std::string& path);

// Memory that decoding takes (decode_zone_glb, decode_bvh_file and assemble_page, without the compressed bytes and the
// page itself). A test measures it. The first reads it from the file and is what NodeRecord::scratch_bytes holds:
// decoding refuses a file that asks for more; the second holds for any file of this size, for records with
// scratch_bytes 0.
std::uint32_t decode_scratch_bytes(std::span<const std::byte> glb, const NodeRecord& node);
std::uint32_t decode_scratch_bound(std::uint32_t triangle_count, std::uint32_t vertex_count, std::uint64_t glb_bytes);

// The check alone, for pages from anywhere.
Status verify_page(std::span<const std::uint32_t> page, std::uint32_t material_count, const std::string& path);

}  // namespace zc
