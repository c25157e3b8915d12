// SPDX-License-Identifier: Apache-2.0
// Small synthetic worlds in memory for the streamer's tests: a full quadtree of zones, each a real Draco GLB and a real
// BVH file, and a source over them whose files can be damaged. The same options give the same bytes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "streamer/source/source.h"
#include "streamer/world_format/bvh_page.h"
#include "streamer/world_format/world_index.h"

namespace zc::test {

struct TinyWorldOptions {
  std::uint32_t levels = 3;  // 4^(levels - 1) leaves
  std::uint32_t grid = 6;    // a zone's ground: grid × grid cells of two triangles; varies by zone
  std::uint32_t soup = 10;   // loose triangles of a second material
  bool detail = false;       // a full-detail child below each leaf
  std::uint32_t seed = 1;
};

using Files = std::map<std::string, std::vector<std::byte>>;

struct TinyWorld {
  WorldIndex index;
  Files files;  // the index included
};

TinyWorld make_tiny_world(const TinyWorldOptions& options = {});
void write_tiny_world(const TinyWorld& world, const std::filesystem::path& dir);

// The world's edge length in metres: its south-west corner is at `kTinyOrigin_m`.
double tiny_world_size_m(const TinyWorldOptions& options);
inline constexpr double kTinyOrigin_m = 1000.0;

enum class TinyStream : std::uint8_t { kEdgebreaker, kSequential, kColored };

// One zone: ground and soup in [0, extent]³ offsets, as Draco GLB. Fills the record's counts and sizes.
struct TinyZone {
  std::vector<std::byte> glb;
  std::vector<std::byte> bvh;
};
TinyZone make_tiny_zone(std::uint32_t grid, std::uint32_t soup, std::uint32_t extent, std::uint32_t seed,
                        NodeRecord& record, TinyStream kind = TinyStream::kEdgebreaker);

// A plain median-split BVH, and the page of a zone's files (which must be sound).
BvhFile build_median_bvh(const ZoneMesh& mesh, const NodeRecord& record);
std::vector<std::uint32_t> page_of(const TinyWorld& world, std::uint32_t node);

class MemorySource final : public Source {
 public:
  explicit MemorySource(Files files) : files_(std::move(files)) {}

  Result<std::vector<std::byte>> read(const std::string& name, std::uint64_t bytes) override;
  Result<std::vector<std::byte>> read_all(const std::string& name, std::uint64_t limit_bytes) override;

  void flip_byte(const std::string& name, std::size_t at);
  void remove(const std::string& name);
  void restore(const std::string& name, std::vector<std::byte> bytes);

 private:
  std::mutex mutex_;
  Files files_;
};

}  // namespace zc::test
