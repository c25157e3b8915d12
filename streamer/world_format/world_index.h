// SPDX-License-Identifier: Apache-2.0
// The binary index `world.zcw`: one fixed-size record per zone node, so that opening a million nodes is a read and a
// hash, not a parse. All integers little-endian.
//
//   WorldHeader | NodeRecord × node_count | MaterialRecord × material_count | CRS text (UTF-8, crs_bytes)
//
// Untrusted input: decode_world_index checks every count, reference and range before anything is used.
// Units: lattice units are steps of 2^step_log2 metres. World lattice positions are relative to `anchor`
// (CRS position in metres = (anchor + position) * step). Thread-safe: plain values.
// Fails when: a record contradicts another or its own counts, or a hash differs (kFormat, with the byte).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "base/large_allocator.h"
#include "base/result.h"

namespace zc {

inline constexpr std::array<char, 8> kWorldMagic = {'Z', 'C', 'W', 'O', 'R', 'L', 'D', '\n'};
inline constexpr std::uint32_t kWorldVersion = 5;
inline constexpr std::int32_t kDefaultStepLog2 = -8;
inline constexpr std::uint32_t kMaxCrsBytes = 64U << 10U;  // of any description, WKT included
inline constexpr const char* kWorldIndexName = "world.zcw";

struct WorldHeader {
  std::array<char, 8> magic = kWorldMagic;
  std::uint32_t version = kWorldVersion;
  std::uint32_t node_count = 0;
  std::uint32_t material_count = 0;
  std::uint32_t crs_bytes = 0;
  std::int32_t step_log2 = kDefaultStepLog2;
  std::uint32_t sun = 0;                    // SunAngles::pack(), of the lit and shadowed triangles; 0: none
  std::array<std::int64_t, 3> anchor = {};  // lattice units, whole metres
  std::array<std::int32_t, 3> bounds_min = {};
  std::array<std::int32_t, 3> bounds_max = {};
  std::uint64_t source_triangles = 0;
  std::uint64_t body_xxh3 = 0;    // of everything after the header
  std::uint64_t header_xxh3 = 0;  // of the header up to this field
};
static_assert(sizeof(WorldHeader) == 8 + 6 * 4 + 24 + 24 + 8 + 16);

// A detail node has the full-detail geometry under a leaf zone. The reflection streamer never asks for it; whoever
// draws full detail (the G-buffer, the reference) does. It is the only child of its leaf zone.
inline constexpr std::uint32_t kNodeDetail = 1U;

// Nodes are ordered so that parents come before children and siblings are contiguous; node 0 is the root.
struct NodeRecord {
  std::int32_t parent = -1;
  std::uint32_t first_child = 0;
  std::uint32_t child_count = 0;
  std::uint32_t flags = 0;
  std::uint32_t depth = 0;  // quadtree depth of the cell; a detail node has its leaf's depth
  std::uint32_t cell_x = 0;
  std::uint32_t cell_y = 0;
  std::uint32_t step_shift = 0;             // the node's step is 2^step_shift lattice units
  std::array<std::int32_t, 3> origin = {};  // lattice; multiple of 2^step_shift
  std::array<std::int32_t, 3> bounds_min =
      {};  // lattice, of the decoded geometry; children lie inside after growing by error
  std::array<std::int32_t, 3> bounds_max = {};
  float error_max_m = 0;  // two-sided surface distance to the full-detail source, a bound
  float error_mean_m = 0;
  float normal_deviation_deg = 0;
  float color_error = 0;  // mean absolute linear RGB difference, 0..1
  std::uint32_t triangle_count = 0;
  std::uint32_t vertex_count = 0;  // in the .glb, summed over primitives
  std::uint32_t bvh_node_count = 0;
  std::uint32_t bvh_depth = 0;
  std::uint32_t page_bytes = 0;     // decoded GPU page
  std::uint32_t scratch_bytes = 0;  // upper bound of memory while decoding, without the page and the compressed bytes
  std::uint32_t primitive_count = 0;
  // How far off the wrong colour a point can be: the largest distance, over samples where node and source
  // look different, to where the appearance is right. At least as fine as the geometry's error when windows vanish in a
  // flat wall.
  float appearance_error_m = 0;
  std::uint32_t reference_count = 0;  // triangles in leaves: at least triangle_count, more with spatial splits
  // Of page_bytes, what is there for the appearances only where the zone needs it.
  std::uint32_t appearance_bytes = 0;  // charts: what stands for texture coordinates
  std::uint32_t light_bytes = 0;
  std::uint32_t normal_bytes = 0;
  std::uint32_t texture_bytes = 0;
  std::uint64_t glb_bytes = 0;
  std::uint64_t bvh_bytes = 0;
  std::uint64_t glb_xxh3 = 0;
  std::uint64_t bvh_xxh3 = 0;

  [[nodiscard]] bool is_detail() const { return (flags & kNodeDetail) != 0; }
  // What decides whether the node is fine enough for a viewer.
  [[nodiscard]] float visible_error_m() const { return std::max(error_max_m, appearance_error_m); }
};
static_assert(sizeof(NodeRecord) == 168);

struct MaterialRecord {
  std::array<float, 3> base_color = {0.8F, 0.8F, 0.8F};  // linear
  float roughness = 0.9F;
  float metallic = 0;
  std::uint32_t flags = 0;
  std::array<std::uint32_t, 2> reserved = {};
};
static_assert(sizeof(MaterialRecord) == 32);

[[nodiscard]] double lattice_step_m(const WorldHeader& header);

struct WorldIndex {
  WorldHeader header;
  std::vector<NodeRecord, LargeAllocator<NodeRecord>> nodes;
  std::vector<MaterialRecord> materials;
  std::string crs;

  [[nodiscard]] double step_m() const { return lattice_step_m(header); }
  // Bytes that the index itself keeps in memory.
  [[nodiscard]] std::uint64_t resident_bytes() const;
};

// "zones/3/5_2.glb", "zones/3/5_2.detail.zbvh": path of a node's file below the world's directory.
std::string node_file(const NodeRecord& node, const char* extension);

std::vector<std::byte> encode_world_index(const WorldIndex& index);  // fills the hashes

// Fills `out` with a file's bytes from there on, which are within the file's size.
using ReadAt = std::function<Status(std::uint64_t offset_bytes, std::span<std::byte> out)>;
// Reads once, in order, to where it stays: a million nodes are 160 MiB.
Result<WorldIndex> decode_world_index(std::uint64_t file_bytes, const ReadAt& read, const std::string& path);
Result<WorldIndex> decode_world_index(std::span<const std::byte> bytes, const std::string& path);

// The same of a world whose nodes stay in the file: all of it is read and checked.
struct IndexInFile {
  WorldIndex index;                       // without its nodes
  std::vector<std::uint64_t> block_xxh3;  // of each block of nodes, see NodeBlocks
};
Result<IndexInFile> check_world_index(std::uint64_t file_bytes, const ReadAt& read, std::size_t nodes_per_block,
                                      const std::string& path);
// What that takes, beside what it returns.
[[nodiscard]] std::uint64_t check_index_bytes(std::uint64_t nodes);
// The header alone; its hash and counts are right.
Result<WorldHeader> read_world_header(std::uint64_t file_bytes, const ReadAt& read, const std::string& path);

}  // namespace zc
