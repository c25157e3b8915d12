// SPDX-License-Identifier: Apache-2.0
// decode_zone_glb: GLB container, glTF JSON, Draco streams. Each layer's counts are held against the index's record
// before the next one takes memory; what draco and the JSON parser throw ends here.
#include <algorithm>
#include <bit>
#include <cstring>
#include <exception>
#include <limits>
#include <optional>

#include <nlohmann/json.hpp>

#include <draco/compression/decode.h>

#include "streamer/world_format/bvh_page.h"
#include "streamer/world_format/draco_tables.h"

namespace zc {
namespace {

using Json = nlohmann::json;

constexpr std::uint32_t kGlbMagic = 0x46546C67;   // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;  // "JSON"
constexpr std::uint32_t kBinChunk = 0x004E4942;   // "BIN\0"
constexpr std::uint64_t kUnsignedShort = 5123;

// What decoding takes, measured with draco 1.5.5 and nlohmann 3.11 (bytes), with room to spare: connectivity and values
// by triangle and vertex, and the tables of the rANS decoders, which the streams themselves name (draco_tables.h).
constexpr std::uint64_t kScratchFixed = 64 << 10U;
constexpr std::uint64_t kScratchPerTriangle = 100;
constexpr std::uint64_t kScratchPerVertex = 56;
// Held from the first primitive to the page: the mesh and what assembling takes. The BVH file comes on top.
constexpr std::uint64_t kHeldPerTriangle = 32;
constexpr std::uint64_t kHeldPerVertex = 16;
constexpr std::uint64_t kHeldPerSplitTriangle = 28;  // its pieces' box
// The decoded BVH file: nodes and the boxes below them, the order and the lists on the way to it.
constexpr std::uint64_t kTreePerNode = sizeof(gpu::PageNode) + 24;
constexpr std::uint64_t kTreePerReference = 3 * sizeof(std::uint32_t) + 1;  // later, with trims, fewer
constexpr std::uint64_t kLightPerVertex = 6 * sizeof(std::uint32_t);
constexpr std::uint64_t kNormalsPerTriangle = sizeof(std::uint32_t) + sizeof(gpu::TriangleNormals);
constexpr std::uint64_t kNormalsPerVertex = 2 * sizeof(std::uint16_t);
constexpr std::uint64_t kScratchPerJsonByte = 24;
constexpr std::uint64_t kSymbolsMost = (1 << 16U) + 1;
constexpr std::uint64_t kJsonMaxBytes = 1 << 20U;
constexpr std::uint64_t kBytesPerJsonValue = 128;

// For streams that cannot be followed: each distinct symbol takes a byte of the stream at least.
std::uint64_t table_bound(std::uint64_t vertex_count, std::uint64_t glb_bytes) {
  return rans_table_bytes(static_cast<unsigned>(std::bit_width(std::min({3 * vertex_count, glb_bytes, kSymbolsMost}))),
                          kSymbolsMost);
}

// What draco takes for one primitive's stream.
std::uint64_t stream_scratch(std::uint64_t triangle_count, std::uint64_t vertex_count, std::uint64_t stream_bytes,
                             std::uint64_t table_bytes) {
  return kScratchPerTriangle * triangle_count + kScratchPerVertex * vertex_count +
         std::min<std::uint64_t>(stream_bytes, 1ULL << 32U) + table_bytes;
}

std::uint32_t clamp_bytes(std::uint64_t bytes) {
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(bytes, std::numeric_limits<std::uint32_t>::max()));
}

// The JSON tree is gone before draco starts, and each stream's decoder before the next.
std::uint32_t scratch(std::uint64_t json_bytes, std::uint64_t largest_stream, const NodeRecord& node) {
  const std::uint64_t json = kScratchPerJsonByte * std::min(json_bytes, kJsonMaxBytes);
  const std::uint64_t held =
      kHeldPerTriangle * node.triangle_count + kHeldPerVertex * node.vertex_count + bvh_scratch_bytes(node);
  return clamp_bytes(kScratchFixed + std::max(json, largest_stream) + held);
}

struct Chunks {
  std::string_view json;
  std::span<const std::byte> bin;
};

struct Primitive {
  std::uint32_t draco_attribute = 0;
  std::uint64_t vertex_count = 0;
  std::span<const std::byte> draco;
};

class ZoneGlb {
 public:
  ZoneGlb(std::span<const std::byte> bytes, const NodeRecord& node, const std::string& path)
      : bytes_(bytes),
        node_(node),
        path_(path),
        allowed_(node.scratch_bytes != 0 ? node.scratch_bytes : decode_scratch_bound(node, bytes.size())) {}

  Result<std::uint32_t> scratch_bytes() {
    allowed_ = std::numeric_limits<std::uint32_t>::max();
    ZC_ASSIGN(const Chunks chunks, split());
    ZC_ASSIGN(const std::vector<Primitive> primitives, read_json(chunks));
    return scratch_of(chunks, primitives);
  }

  Result<ZoneMesh> decode() {
    ZC_ASSIGN(const Chunks chunks, split());
    ZC_ASSIGN(const std::vector<Primitive> primitives, read_json(chunks));
    ZC_ASSIGN(const std::uint32_t needed, scratch_of(chunks, primitives));
    if (needed > allowed_) return fault("decoding takes more memory than the index says");
    ZoneMesh mesh;
    mesh.vertices.reserve(node_.vertex_count);
    mesh.triangles.reserve(node_.triangle_count);
    for (const Primitive& primitive : primitives) ZC_TRY(append(primitive, mesh));
    if (mesh.triangles.size() != node_.triangle_count) return fault("has fewer triangles than the index says");
    return mesh;
  }

 private:
  [[nodiscard]] Error fault(std::string cause, std::int64_t at = -1) const {
    return {ErrorCode::kFormat, std::move(cause), path_, at};
  }

  [[nodiscard]] Result<std::uint32_t> scratch_of(const Chunks& chunks, const std::vector<Primitive>& primitives) const {
    std::uint64_t largest = 0;
    for (const Primitive& primitive : primitives) {
      const auto counts = read_draco_counts(primitive);
      const std::uint64_t triangles =
          counts.ok() ? std::min<std::uint64_t>(counts->faces, node_.triangle_count) : node_.triangle_count;
      const std::optional<std::uint64_t> tables = draco_table_bytes(primitive.draco);
      if (!tables) return fault("Draco stream is damaged or of a kind that zones do not have");
      largest = std::max(largest, stream_scratch(triangles, primitive.vertex_count, primitive.draco.size(), *tables));
    }
    return scratch(chunks.json.size(), largest, node_);
  }

  [[nodiscard]] std::uint32_t word(std::size_t at) const {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes_.data() + at, sizeof value);
    return value;
  }

  [[nodiscard]] Result<Chunks> split() const {
    if (bytes_.size() < 20) return fault("too short for a GLB", static_cast<std::int64_t>(bytes_.size()));
    if (word(0) != kGlbMagic || word(4) != 2) return fault("not a GLB of version 2", 0);
    if (word(8) != bytes_.size()) return fault("GLB length does not match the file", 8);
    const std::size_t json_bytes = word(12);
    if (word(16) != kJsonChunk) return fault("the first chunk is not JSON", 16);
    if (json_bytes > bytes_.size() - 20 || json_bytes > kJsonMaxBytes) return fault("JSON chunk too long", 12);
    Chunks chunks;
    chunks.json = {reinterpret_cast<const char*>(bytes_.data()) + 20, json_bytes};
    const std::size_t bin_at = 20 + json_bytes;
    if (bytes_.size() - bin_at < 8) return fault("no binary chunk", static_cast<std::int64_t>(bin_at));
    if (word(bin_at + 4) != kBinChunk)
      return fault("the second chunk is not binary", static_cast<std::int64_t>(bin_at + 4));
    if (word(bin_at) > bytes_.size() - bin_at - 8)
      return fault("binary chunk too long", static_cast<std::int64_t>(bin_at));
    chunks.bin = bytes_.subspan(bin_at + 8, word(bin_at));
    return chunks;
  }

  // The member if `value` is an object that has it.
  static const Json* member(const Json* value, const char* key) {
    if (value == nullptr || !value->is_object()) return nullptr;
    const auto found = value->find(key);
    return found == value->end() ? nullptr : &*found;
  }
  static const Json* element(const Json* value, std::optional<std::uint64_t> i) {
    return value != nullptr && value->is_array() && i && *i < value->size() ? &(*value)[*i] : nullptr;
  }
  static std::optional<std::uint64_t> count_of(const Json* value) {
    if (value == nullptr || !value->is_number_unsigned()) return std::nullopt;
    return value->get<std::uint64_t>();
  }

  [[nodiscard]] Result<std::vector<Primitive>> read_json(const Chunks& chunks) const {
    const auto structural = static_cast<std::uint64_t>(std::count_if(
        chunks.json.begin(), chunks.json.end(), [](char c) { return c == '{' || c == '[' || c == ',' || c == ':'; }));
    if (structural * kBytesPerJsonValue + 2 * chunks.json.size() > allowed_)
      return fault("JSON has too many values", 20);
    const Json root = Json::parse(chunks.json, nullptr, false);
    if (root.is_discarded()) return fault("malformed JSON", 20);

    const Json* meshes = member(&root, "meshes");
    if (meshes == nullptr || !meshes->is_array() || meshes->size() != 1) return fault("must have exactly one mesh", 20);
    const Json* list = member(&meshes->front(), "primitives");
    if (list == nullptr || !list->is_array() || list->size() != node_.primitive_count)
      return fault("number of primitives differs from the index", 20);
    std::vector<Primitive> primitives;
    primitives.reserve(list->size());
    std::uint64_t vertices = 0;
    for (const Json& entry : *list) {
      ZC_ASSIGN(Primitive primitive, read_primitive(root, entry, chunks.bin));
      vertices += primitive.vertex_count;
      if (vertices > node_.vertex_count) return fault("has more vertices than the index says", 20);
      primitives.push_back(primitive);
    }
    return primitives;
  }

  [[nodiscard]] Result<Primitive> read_primitive(const Json& root, const Json& entry,
                                                 std::span<const std::byte> bin) const {
    const Json* mode = member(&entry, "mode");
    if (mode != nullptr && count_of(mode) != 4) return fault("a primitive is not a triangle list", 20);
    const Json* accessor =
        element(member(&root, "accessors"), count_of(member(member(&entry, "attributes"), "POSITION")));
    const Json* type = member(accessor, "type");
    const Json* normalized = member(accessor, "normalized");
    const std::optional<std::uint64_t> vertices = count_of(member(accessor, "count"));
    if (count_of(member(accessor, "componentType")) != kUnsignedShort || type == nullptr || *type != "VEC3" ||
        (normalized != nullptr && *normalized != false) || !vertices || *vertices > node_.vertex_count)
      return fault("POSITION is not the unnormalised 16-bit accessor that a zone has", 20);

    const Json* draco = member(member(&entry, "extensions"), "KHR_draco_mesh_compression");
    const std::optional<std::uint64_t> attribute = count_of(member(member(draco, "attributes"), "POSITION"));
    const Json* view = element(member(&root, "bufferViews"), count_of(member(draco, "bufferView")));
    const std::optional<std::uint64_t> length = count_of(member(view, "byteLength"));
    const std::uint64_t offset = count_of(member(view, "byteOffset")).value_or(0);
    if (!attribute || *attribute > std::numeric_limits<std::uint32_t>::max())
      return fault("a primitive is not Draco-compressed", 20);
    if (count_of(member(view, "buffer")) != 0U || !length || offset > bin.size() || *length > bin.size() - offset)
      return fault("a buffer view leaves the binary chunk", 20);

    return Primitive{static_cast<std::uint32_t>(*attribute), *vertices, bin.subspan(offset, *length)};
  }

  // Draco takes memory as its own header asks, so that is read first: (Draco bitstream 2.2, sections "ParseHeader",
  // "ParseEdgebreakerConnectivityData", "DecodeSequentialConnectivityData".)
  struct DracoCounts {
    std::uint64_t faces = 0;
    std::uint64_t vertices = 0;
    bool edgebreaker = false;
  };
  [[nodiscard]] Result<DracoCounts> read_draco_counts(const Primitive& primitive) const {
    const std::span<const std::byte> data = primitive.draco;
    const auto byte = [&](std::size_t i) { return static_cast<std::uint32_t>(data[i]); };
    if (data.size() < 13 || std::memcmp(data.data(), "DRACO", 5) != 0) return fault("not a Draco stream");
    if (byte(5) != 2 || byte(6) != 2) return fault("Draco bitstream is not version 2.2");
    if (byte(7) != 1 || byte(8) > 1) return fault("Draco stream is not a mesh");
    if (byte(9) != 0 || byte(10) != 0) return fault("Draco stream has metadata");
    DracoCounts counts;
    counts.edgebreaker = byte(8) == 1;
    std::size_t at = counts.edgebreaker ? 12 : 11;  // after the traversal type
    const auto varint = [&]() -> std::uint64_t {
      std::uint64_t value = 0;
      for (unsigned shift = 0; at < data.size() && shift < 35; shift += 7) {
        const std::uint32_t b = byte(at++);
        value |= std::uint64_t{b & 0x7FU} << shift;
        if ((b & 0x80U) == 0) return value;
      }
      return std::numeric_limits<std::uint32_t>::max() + 1ULL;
    };
    const std::uint64_t first = varint();
    const std::uint64_t second = varint();
    counts.faces = counts.edgebreaker ? second : first;
    counts.vertices = counts.edgebreaker ? first : second;
    return counts;
  }

  [[nodiscard]] Status check_draco_header(const Primitive& primitive, std::uint64_t faces_left) const {
    ZC_ASSIGN(const DracoCounts counts, read_draco_counts(primitive));
    // Edgebreaker's own count is of the connectivity's vertices, before or after splits; draco allows three a face.
    const std::uint64_t vertices_most = counts.edgebreaker ? 3 * faces_left : primitive.vertex_count;
    if (counts.faces > faces_left || counts.vertices > vertices_most)
      return fault("Draco stream has more triangles or vertices than the index says");
    return {};
  }

  [[nodiscard]] Status append(const Primitive& primitive, ZoneMesh& mesh) const {
    const std::uint64_t faces_left = node_.triangle_count - mesh.triangles.size();
    ZC_TRY(check_draco_header(primitive, faces_left));
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(primitive.draco.data()), primitive.draco.size());
    draco::Decoder decoder;
    auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
    if (!decoded.ok()) return fault(std::string("Draco: ") + decoded.status().error_msg());
    const draco::Mesh& source = *decoded.value();
    if (source.num_points() != primitive.vertex_count || source.num_faces() > faces_left)
      return fault("Draco stream has other counts than its accessor");

    const draco::PointAttribute* position = source.GetAttributeByUniqueId(primitive.draco_attribute);
    if (position == nullptr || position->data_type() != draco::DT_UINT16 || position->num_components() != 3 ||
        position->byte_stride() != 6 || position->buffer() == nullptr)
      return fault("Draco stream has no 16-bit POSITION");
    // Values, not points: those are split where colours meet.
    const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
    if (position->size() > primitive.vertex_count) return fault("Draco stream has more positions than points");
    for (draco::AttributeValueIndex v(0); v < static_cast<std::uint32_t>(position->size()); ++v) {
      std::array<std::uint16_t, 3> vertex = {};
      position->GetValue(v, vertex.data());
      mesh.vertices.push_back(vertex);
    }
    for (draco::FaceIndex f(0); f < source.num_faces(); ++f) {
      std::array<std::uint32_t, 3> triangle{};
      for (std::size_t k = 0; k < 3; ++k) {
        const draco::PointIndex point = source.face(f)[k];
        if (point.value() >= source.num_points()) return fault("Draco stream refers to a missing vertex");
        const draco::AttributeValueIndex value = position->mapped_index(point);
        if (value.value() >= position->size()) return fault("Draco stream refers to a missing value");
        triangle[k] = base + value.value();
      }
      mesh.triangles.push_back(triangle);
    }
    return {};
  }

  std::span<const std::byte> bytes_;
  const NodeRecord& node_;
  const std::string& path_;
  std::uint32_t allowed_;
};

}  // namespace

std::uint32_t bvh_scratch_bytes(const NodeRecord& node) {
  const std::uint64_t triangles = node.triangle_count;
  std::uint64_t bytes = kTreePerNode * node.bvh_node_count + kTreePerReference * node.reference_count;
  if (node.reference_count > node.triangle_count) bytes += kHeldPerSplitTriangle * triangles;
  if (node.look_bytes > 0) bytes += sizeof(std::uint16_t) * triangles + node.look_bytes;
  if (node.light_bytes > 0) bytes += sizeof(gpu::TriangleLight) * triangles + kLightPerVertex * node.vertex_count;
  if (node.normal_bytes > 0) bytes += kNormalsPerTriangle * triangles + kNormalsPerVertex * node.vertex_count;
  return clamp_bytes(bytes + node.texture_bytes);
}

std::uint32_t decode_scratch_bound(const NodeRecord& node, std::uint64_t glb_bytes) {
  return scratch(
      glb_bytes,
      stream_scratch(node.triangle_count, node.vertex_count, glb_bytes, table_bound(node.vertex_count, glb_bytes)),
      node);
}

std::uint32_t decode_scratch_bytes(std::span<const std::byte> glb, const NodeRecord& node) {
  const std::string path;
  try {
    const Result<std::uint32_t> bytes = ZoneGlb(glb, node, path).scratch_bytes();
    if (bytes.ok()) return *bytes;
  } catch (const std::exception&) {  // then the bound has to do
  }
  return decode_scratch_bound(node, glb.size());
}

Result<ZoneMesh> decode_zone_glb(std::span<const std::byte> bytes, const NodeRecord& node, const std::string& path) {
  try {
    return ZoneGlb(bytes, node, path).decode();
  } catch (const std::exception& exception) {
    return Error{ErrorCode::kFormat, std::string("cannot decode: ") + exception.what(), path};
  }
}

}  // namespace zc
