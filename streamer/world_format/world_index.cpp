// SPDX-License-Identifier: Apache-2.0
#include "streamer/world_format/world_index.h"

#include <xxhash.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>

#include "base/check.h"
#include "shaders/shared/page.h"
#include "streamer/world_format/bvh_page.h"
#include "streamer/world_format/sun_angles.h"

namespace zc {
namespace {

static_assert(std::endian::native == std::endian::little, "the files are little-endian and read by memcpy");

constexpr std::uint32_t kMaxMaterials = 1U << 16U;  // a page's triangle has 16 bits for one
constexpr std::uint32_t kMaxDepth = 30;
constexpr std::uint32_t kMaxStepShift = 15;
constexpr std::uint64_t kReferencesMost = 2;  // spatial splits at most double a zone's triangles
// Three vertices, two words of palette, a cluster's header and entry with their padding.
constexpr std::uint64_t kWordsPerReferenceMost = 5 + 2 + gpu::kClusterHeaderWords + gpu::kClusterEntryWords + 6;
constexpr std::uint64_t kTextureBytesMost = (2ULL << (2 * gpu::kAtlasMaxLog2)) / 3;  // BC1 with all its levels
constexpr std::uint64_t kAppearanceFileBytesMost = sizeof(gpu::Appearance) * std::uint64_t{kZoneAppearancesMax};
// Which appearance, light, normals and whose they are.
constexpr std::uint64_t kAppearanceFileBytesPerTriangle =
    4 + sizeof(gpu::TriangleLight) + sizeof(gpu::TriangleNormals) + sizeof(std::uint32_t);
constexpr std::uint64_t kMaxFileBytes = 0xFFFFFFFFULL;  // a GLB's own length field has 32 bits

Error node_error(const std::string& path, std::size_t node, const char* cause) {
  return {ErrorCode::kFormat, "node " + std::to_string(node) + ": " + cause, path,
          static_cast<std::int64_t>(sizeof(WorldHeader) + node * sizeof(NodeRecord))};
}

bool ordered(const std::array<std::int32_t, 3>& low, const std::array<std::int32_t, 3>& high) {
  return low[0] <= high[0] && low[1] <= high[1] && low[2] <= high[2];
}

bool sane(float value) { return std::isfinite(value) && value >= 0.0F; }

// Of a node: why it cannot be, or nothing.

// What a node says of its children, which is all that they are checked against.
struct Family {
  std::uint32_t first_child = 0;
  std::uint32_t child_count = 0;
  std::uint8_t depth = 0;
  bool is_detail = false;
};

Family family_of(const NodeRecord& node) {  // which is in place: its depth is small
  return {node.first_child, node.child_count, static_cast<std::uint8_t>(node.depth), node.is_detail()};
}

// Every node but the root lies in its parent's range, and the ranges have one place for each, which `places` counts: so
// each node has exactly one parent, and that parent comes before it. family(p): of the node p before this one, the i-th
// of `count`.
template <class FamilyOf>
const char* tree_fault(const NodeRecord& node, std::size_t i, std::size_t count, const FamilyOf& family,
                       std::uint64_t& places) {
  if (node.child_count > 0) {
    if (node.first_child <= i || node.first_child >= count || node.child_count > count - node.first_child)
      return "children out of range";
    places += node.child_count;
  }
  if (i == 0) {
    if (node.parent != -1) return "the root has a parent";
    if (node.is_detail()) return "the root is a detail node";
    return nullptr;
  }
  if (node.parent < 0 || static_cast<std::size_t>(node.parent) >= i) return "parent out of range";
  const Family parent = family(static_cast<std::size_t>(node.parent));
  if (i < parent.first_child || i - parent.first_child >= parent.child_count) return "not among its parent's children";
  // So that whoever goes down the tree goes down kMaxDepth and one more at most.
  if (node.depth < parent.depth + (node.is_detail() ? 0U : 1U)) return "does not lie below its parent";
  if (node.is_detail() && (parent.is_detail || parent.child_count != 1 || node.child_count != 0))
    return "a detail node must be the only child of a zone and have no children";
  return nullptr;
}

const char* counts_fault(const NodeRecord& node) {
  if (node.triangle_count == 0 || node.triangle_count > gpu::kPageMaxTriangles) return "triangle count out of range";
  if (node.vertex_count == 0 || node.vertex_count > 3ULL * node.triangle_count) return "vertex count out of range";
  if (node.primitive_count == 0 || node.primitive_count > node.triangle_count) return "primitive count out of range";
  if (node.reference_count < node.triangle_count || node.reference_count > kReferencesMost * node.triangle_count ||
      node.reference_count > gpu::kPageMaxTriangles)
    return "reference count out of range";
  if (node.bvh_node_count == 0 || node.bvh_node_count > node.reference_count) return "BVH node count out of range";
  if (node.bvh_depth == 0 || node.bvh_depth > gpu::kPageMaxDepth) return "BVH depth out of range";
  const std::uint64_t appearances =
      std::uint64_t{node.appearance_bytes} + node.light_bytes + node.normal_bytes + node.texture_bytes;
  // A tree that is coded so badly that it takes more would be no use to anybody.
  const std::uint64_t bvh_least = sizeof(BvhFileHeader) + std::uint64_t{node.texture_bytes};
  const std::uint64_t bvh_most =
      bvh_least + std::uint64_t{sizeof(gpu::PageNode)} * node.bvh_node_count +
      2 * sizeof(std::uint32_t) * std::uint64_t{node.reference_count} +
      (appearances > 0 ? kAppearanceFileBytesMost + kAppearanceFileBytesPerTriangle * node.triangle_count : 0);
  if (node.bvh_bytes < bvh_least || node.bvh_bytes > bvh_most || node.texture_bytes > kTextureBytesMost)
    return "BVH file size does not follow from its counts";
  // What a page contains beside nodes and triangles depends on how the clusters share vertices: assembly checks that.
  const std::uint64_t words_least = std::uint64_t{gpu::kPageHeaderWords} +
                                    std::uint64_t{gpu::kPageNodeWords} * node.bvh_node_count +
                                    gpu::kClusterHeaderWords + gpu::kClusterEntryWords + node.reference_count;
  if (node.page_bytes % (4 * gpu::kPageAlignWords) != 0 || node.page_bytes < 4 * words_least ||
      node.page_bytes > 4 * (words_least + kWordsPerReferenceMost * node.reference_count) + appearances)
    return "page size does not follow from its counts";
  if (node.glb_bytes < 20 || node.glb_bytes > kMaxFileBytes) return "GLB size out of range";
  return nullptr;
}

const char* place_fault(const NodeRecord& node) {
  if ((node.flags & ~kNodeDetail) != 0) return "unknown flags";
  if (node.depth > kMaxDepth) return "depth out of range";
  if ((node.cell_x >> node.depth) != 0 || (node.cell_y >> node.depth) != 0) return "cell out of range";
  if (node.step_shift > kMaxStepShift) return "step shift out of range";
  if (!ordered(node.bounds_min, node.bounds_max)) return "empty bounds";
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t origin = node.origin[axis];
    if ((origin & ((1LL << node.step_shift) - 1)) != 0) return "origin is off its lattice";
    if (node.bounds_min[axis] < origin || node.bounds_max[axis] > origin + (0xFFFFLL << node.step_shift))
      return "bounds do not fit 16-bit offsets";
  }
  if (!sane(node.error_max_m) || !sane(node.error_mean_m) || !sane(node.normal_deviation_deg) ||
      !sane(node.color_error) || !sane(node.appearance_error_m))
    return "an error bound is not a number";
  return nullptr;
}

Status check_header(const WorldHeader& header, std::uint64_t file_bytes, const std::string& path) {
  const auto fault = [&](const char* cause, std::size_t at) {
    return Error{ErrorCode::kFormat, cause, path, static_cast<std::int64_t>(at)};
  };
  if (header.magic != kWorldMagic) return fault("not a zonecast world index", 0);
  if (header.version != kWorldVersion)
    return Error{
        ErrorCode::kUnsupported,
        "index version " + std::to_string(header.version) + ", this program reads " + std::to_string(kWorldVersion),
        path, offsetof(WorldHeader, version)};
  if (header.header_xxh3 != XXH3_64bits(&header, offsetof(WorldHeader, header_xxh3)))
    return fault("header hash mismatch", offsetof(WorldHeader, header_xxh3));
  if (header.node_count == 0) return fault("no nodes", offsetof(WorldHeader, node_count));
  if (header.material_count == 0 || header.material_count > kMaxMaterials)
    return fault("material count out of range", offsetof(WorldHeader, material_count));
  if (header.crs_bytes > kMaxCrsBytes)
    return fault("the name of the reference system is too long", offsetof(WorldHeader, crs_bytes));
  // 32-bit counts times small sizes: no overflow in 64 bits.
  const std::uint64_t expected = sizeof(WorldHeader) + std::uint64_t{header.node_count} * sizeof(NodeRecord) +
                                 std::uint64_t{header.material_count} * sizeof(MaterialRecord) + header.crs_bytes;
  if (expected != file_bytes)
    return Error{ErrorCode::kFormat,
                 "is " + std::to_string(file_bytes) + " bytes, its counts ask for " + std::to_string(expected), path};
  if (header.step_log2 < -30 || header.step_log2 > 10)
    return fault("lattice step out of range", offsetof(WorldHeader, step_log2));
  if (header.sun != 0 && !SunAngles::unpack(header.sun))
    return fault("no sun stands there", offsetof(WorldHeader, sun));
  if (!ordered(header.bounds_min, header.bounds_max)) return fault("empty bounds", offsetof(WorldHeader, bounds_min));
  return {};
}

Status check_materials(const std::vector<MaterialRecord>& materials, const std::string& path) {
  for (std::size_t i = 0; i < materials.size(); ++i) {
    const MaterialRecord& m = materials[i];
    if (!sane(m.base_color[0]) || !sane(m.base_color[1]) || !sane(m.base_color[2]) || !sane(m.roughness) ||
        !sane(m.metallic))
      return Error{ErrorCode::kFormat, "material " + std::to_string(i) + ": a value is not a number", path};
  }
  return {};
}

template <class T>
void append(std::vector<std::byte>& out, const T* values, std::size_t count) {
  if (count == 0) return;
  const std::size_t at = out.size();
  out.resize(at + count * sizeof(T));
  std::memcpy(out.data() + at, values, count * sizeof(T));
}

// Reads what comes after the header, in order, and hashes it.
class Body {
 public:
  explicit Body(const ReadAt& read) : read_(read), hash_(XXH3_createState()) {
    ZC_CHECK(hash_ != nullptr && XXH3_64bits_reset(hash_.get()) == XXH_OK);
  }
  template <class T>
  Status take(std::span<T> out) {
    const std::span<std::byte> bytes = std::as_writable_bytes(out);
    ZC_TRY(read_(at_, bytes));
    at_ += bytes.size();
    XXH3_64bits_update(hash_.get(), bytes.data(), bytes.size());
    return {};
  }
  [[nodiscard]] std::uint64_t xxh3() const { return XXH3_64bits_digest(hash_.get()); }

 private:
  struct Free {
    void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
  };
  const ReadAt& read_;
  std::uint64_t at_ = sizeof(WorldHeader);
  std::unique_ptr<XXH3_state_t, Free> hash_;
};

// So many records stay in a core's cache from reading to checking.
constexpr std::size_t kRecordsAtOnce = 4096;

// All nodes, in memory.
class NodesInMemory {
 public:
  NodesInMemory(decltype(WorldIndex::nodes)& nodes, std::size_t count) : nodes_(nodes) { nodes.reserve(count); }
  std::span<NodeRecord> next(std::size_t count) {
    nodes_.resize(nodes_.size() + count, NodeRecord());
    return std::span(nodes_).last(count);
  }
  void read(std::span<const NodeRecord> /*records*/) {}
  void checked(const NodeRecord& /*node*/) {}
  [[nodiscard]] Family family(std::size_t node) const { return family_of(nodes_[node]); }

 private:
  decltype(WorldIndex::nodes)& nodes_;
};

// Of all nodes, what those after them are checked against, and the blocks' hashes.
class NodesInFile {
 public:
  NodesInFile(std::vector<std::uint64_t>& block_xxh3, std::size_t nodes_per_block, std::size_t count)
      : block_xxh3_(block_xxh3), nodes_per_block_(nodes_per_block), records_(std::min(count, kRecordsAtOnce)) {
    ZC_CHECK(kRecordsAtOnce % nodes_per_block == 0);
    block_xxh3.reserve((count + nodes_per_block - 1) / nodes_per_block);
    families_.reserve(count);
  }
  std::span<NodeRecord> next(std::size_t count) { return std::span(records_).first(count); }
  void read(std::span<const NodeRecord> records) {
    for (; !records.empty(); records = records.subspan(std::min(records.size(), nodes_per_block_))) {
      const std::span<const NodeRecord> block = records.first(std::min(records.size(), nodes_per_block_));
      block_xxh3_.push_back(XXH3_64bits(block.data(), block.size_bytes()));
    }
  }
  void checked(const NodeRecord& node) { families_.push_back(family_of(node)); }
  [[nodiscard]] Family family(std::size_t node) const { return families_[node]; }

 private:
  std::vector<std::uint64_t>& block_xxh3_;
  std::size_t nodes_per_block_;
  std::vector<NodeRecord> records_;
  std::vector<Family> families_;
};

// `fault`: the first that was found, which counts only when the hash is right.
template <class Nodes>
Status take_nodes(Body& body, std::size_t count, const std::string& path, Nodes nodes, Status& fault) {
  std::uint64_t places = 0;
  for (std::size_t begin = 0; begin < count; begin += kRecordsAtOnce) {
    const std::span<NodeRecord> records = nodes.next(std::min(count - begin, kRecordsAtOnce));
    ZC_TRY(body.take(records));
    nodes.read(records);
    for (std::size_t i = 0; fault.ok() && i < records.size(); ++i) {
      const NodeRecord& node = records[i];
      const char* cause = place_fault(node);
      if (cause == nullptr) cause = counts_fault(node);
      if (cause == nullptr)
        cause = tree_fault(
            node, begin + i, count, [&](std::size_t parent) { return nodes.family(parent); }, places);
      if (cause != nullptr) fault = node_error(path, begin + i, cause);
      nodes.checked(node);
    }
  }
  if (fault.ok() && places != count - 1) fault = node_error(path, 0, "a node belongs to two parents");
  return {};
}

// What comes after the nodes; `fault`: theirs.
Status take_rest(Body& body, const std::string& path, const Status& fault, WorldIndex& index) {
  index.materials.resize(index.header.material_count);
  ZC_TRY(body.take(std::span(index.materials)));
  index.crs.resize(index.header.crs_bytes);
  ZC_TRY(body.take(std::span(index.crs)));
  if (index.header.body_xxh3 != body.xxh3())
    return Error{ErrorCode::kFormat, "body hash mismatch", path, offsetof(WorldHeader, body_xxh3)};
  ZC_TRY(Status(fault));
  return check_materials(index.materials, path);
}

}  // namespace

double lattice_step_m(const WorldHeader& header) { return std::ldexp(1.0, header.step_log2); }

std::uint64_t WorldIndex::resident_bytes() const {
  return sizeof(WorldIndex) + nodes.size() * sizeof(NodeRecord) + materials.size() * sizeof(MaterialRecord) +
         crs.size();
}

std::string node_file(const NodeRecord& node, const char* extension) {
  std::string name = "zones/" + std::to_string(node.depth) + "/" + std::to_string(node.cell_x) + "_" +
                     std::to_string(node.cell_y) + (node.is_detail() ? ".detail" : "");
  if (extension[0] != '.') name += '.';
  return name + extension;
}

std::vector<std::byte> encode_world_index(const WorldIndex& index) {
  ZC_CHECK(index.nodes.size() <= std::numeric_limits<std::uint32_t>::max());
  ZC_CHECK(index.materials.size() <= kMaxMaterials && index.crs.size() <= kMaxCrsBytes);
  WorldHeader header = index.header;
  header.node_count = static_cast<std::uint32_t>(index.nodes.size());
  header.material_count = static_cast<std::uint32_t>(index.materials.size());
  header.crs_bytes = static_cast<std::uint32_t>(index.crs.size());

  std::vector<std::byte> out;
  out.reserve(sizeof(WorldHeader) + index.nodes.size() * sizeof(NodeRecord) +
              index.materials.size() * sizeof(MaterialRecord) + index.crs.size());
  out.resize(sizeof(WorldHeader));
  append(out, index.nodes.data(), index.nodes.size());
  append(out, index.materials.data(), index.materials.size());
  append(out, index.crs.data(), index.crs.size());
  header.body_xxh3 = XXH3_64bits(out.data() + sizeof(WorldHeader), out.size() - sizeof(WorldHeader));
  header.header_xxh3 = XXH3_64bits(&header, offsetof(WorldHeader, header_xxh3));
  std::memcpy(out.data(), &header, sizeof header);
  return out;
}

Result<WorldHeader> read_world_header(std::uint64_t file_bytes, const ReadAt& read, const std::string& path) {
  WorldHeader header;
  if (file_bytes < sizeof(WorldHeader))
    return Error{ErrorCode::kFormat, "too short for an index", path, static_cast<std::int64_t>(file_bytes)};
  ZC_TRY(read(0, std::as_writable_bytes(std::span(&header, 1))));
  ZC_TRY(check_header(header, file_bytes, path));
  return header;
}

Result<WorldIndex> decode_world_index(std::uint64_t file_bytes, const ReadAt& read, const std::string& path) {
  WorldIndex index;
  ZC_ASSIGN(index.header, read_world_header(file_bytes, read, path));
  Body body(read);
  Status fault;
  const std::size_t count = index.header.node_count;
  ZC_TRY(take_nodes(body, count, path, NodesInMemory(index.nodes, count), fault));
  ZC_TRY(take_rest(body, path, fault, index));
  return index;
}

Result<IndexInFile> check_world_index(std::uint64_t file_bytes, const ReadAt& read, std::size_t nodes_per_block,
                                      const std::string& path) {
  IndexInFile out;
  ZC_ASSIGN(out.index.header, read_world_header(file_bytes, read, path));
  Body body(read);
  Status fault;
  const std::size_t count = out.index.header.node_count;
  ZC_TRY(take_nodes(body, count, path, NodesInFile(out.block_xxh3, nodes_per_block, count), fault));
  ZC_TRY(take_rest(body, path, fault, out.index));
  return out;
}

std::uint64_t check_index_bytes(std::uint64_t nodes) {
  return nodes * sizeof(Family) + kRecordsAtOnce * sizeof(NodeRecord);
}

Result<WorldIndex> decode_world_index(std::span<const std::byte> bytes, const std::string& path) {
  const ReadAt read = [&](std::uint64_t offset, std::span<std::byte> out) -> Status {
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(offset), out.size(), out.begin());
    return {};
  };
  return decode_world_index(bytes.size(), read, path);
}

}  // namespace zc
