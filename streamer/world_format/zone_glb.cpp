// SPDX-License-Identifier: Apache-2.0
// decode_zone_glb: GLB container, glTF JSON, Draco streams. Each layer's counts are compared with the index's record
// before the next one takes memory; what the JSON parser throws ends here.
#include <algorithm>
#include <cstring>
#include <exception>
#include <limits>
#include <optional>

#include <nlohmann/json.hpp>

#include "streamer/draco/layout.h"
#include "streamer/draco/mesh.h"
#include "streamer/world_format/bvh_page.h"
#include "streamer/world_format/scratch_memory.h"

namespace zc {
namespace {

using Json = nlohmann::json;

constexpr std::uint32_t kGlbMagic = 0x46546C67;   // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;  // "JSON"
constexpr std::uint32_t kBinChunk = 0x004E4942;   // "BIN\0"
constexpr std::uint64_t kUnsignedShort = 5123;

constexpr std::uint64_t kJsonMaxBytes = 1 << 20U;
constexpr std::uint64_t kBytesPerJsonValue = 128;  // measured with nlohmann 3.11, with room to spare
constexpr std::uint64_t kJsonBytesPerValue = 4;    // of what zones have; for files that nobody has seen yet
constexpr std::uint64_t kFixed = 4 << 10U;         // names, messages

std::uint64_t json_scratch(std::uint64_t values, std::uint64_t json_bytes) {
  return values * kBytesPerJsonValue + 2 * json_bytes;
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

// What comes out and what decode_draco works in.
std::uint64_t mesh_scratch(std::uint64_t triangles, std::uint64_t vertices, std::uint64_t words) {
  return array_scratch<std::array<std::uint32_t, 3>>(triangles) +
         array_scratch<std::array<std::uint16_t, 3>>(vertices) + array_scratch<std::uint32_t>(words);
}

// The JSON tree is gone before the mesh is there, and what that was decoded in before the page.
std::uint32_t scratch(const NodeRecord& node, std::uint64_t json, std::uint64_t mesh, std::uint64_t vertices) {
  const std::uint64_t glb = std::max(json, mesh) + sizeof(Primitive) * node.primitive_count + kFixed;
  return std::max(clamp_bytes(glb), page_scratch_bytes(node, vertices));
}

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
    ZC_ASSIGN(const Needs needs, needs_of(chunks, primitives));
    return needs.scratch_bytes;
  }

  Result<ZoneMesh> decode() {
    ZC_ASSIGN(const Chunks chunks, split());
    ZC_ASSIGN(const std::vector<Primitive> primitives, read_json(chunks));
    ZC_ASSIGN(const Needs needs, needs_of(chunks, primitives));
    if (needs.scratch_bytes > allowed_) return fault("decoding takes more memory than the index says");
    ZoneMesh mesh;
    mesh.vertices.resize(needs.vertices);
    mesh.triangles.resize(node_.triangle_count);
    std::vector<std::uint32_t> words(needs.words);
    std::uint32_t vertex = 0;
    std::uint32_t triangle = 0;
    for (const Primitive& primitive : primitives) {
      ZC_ASSIGN(const DracoLayout layout, layout_of(primitive));
      const std::span triangles = std::span(mesh.triangles).subspan(triangle, layout.faces);
      if (!decode_draco(layout, std::span(mesh.vertices).subspan(vertex, layout.values), triangles, words))
        return fault("Draco stream is damaged");
      for (auto& corners : triangles)
        for (std::uint32_t& corner : corners) corner += vertex;
      vertex += layout.values;
      triangle += layout.faces;
    }
    return mesh;
  }

 private:
  [[nodiscard]] Error fault(std::string cause, std::int64_t at = -1) const {
    return {ErrorCode::kFormat, std::move(cause), path_, at};
  }

  [[nodiscard]] Result<DracoLayout> layout_of(const Primitive& primitive) const {
    DracoLayout layout;
    if (const char* cause = read_draco_layout(primitive.draco, primitive.draco_attribute, layout)) return fault(cause);
    return layout;
  }

  // What the streams say of themselves. Positions may be fewer than points: those are split where colours differ.
  struct Needs {
    std::uint32_t vertices = 0;
    std::uint64_t words = 0;
    std::uint32_t scratch_bytes = 0;
  };
  [[nodiscard]] Result<Needs> needs_of(const Chunks& chunks, const std::vector<Primitive>& primitives) const {
    Needs needs;
    std::uint32_t triangles = 0;
    for (const Primitive& primitive : primitives) {
      ZC_ASSIGN(const DracoLayout layout, layout_of(primitive));
      if (layout.faces > node_.triangle_count - triangles || layout.values > primitive.vertex_count)
        return fault("Draco stream has more triangles or vertices than the index says");
      triangles += layout.faces;
      needs.vertices += layout.values;
      needs.words = std::max(needs.words, layout.scratch_words());
    }
    if (triangles != node_.triangle_count) return fault("has fewer triangles than the index says");
    const std::uint64_t json = json_scratch(json_values(chunks.json), chunks.json.size());
    needs.scratch_bytes = scratch(node_, json, mesh_scratch(triangles, needs.vertices, needs.words), needs.vertices);
    return needs;
  }

  static std::uint64_t json_values(std::string_view json) {
    return static_cast<std::uint64_t>(
        std::count_if(json.begin(), json.end(), [](char c) { return c == '{' || c == '[' || c == ',' || c == ':'; }));
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
    if (json_scratch(json_values(chunks.json), chunks.json.size()) > allowed_)
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

  std::span<const std::byte> bytes_;
  const NodeRecord& node_;
  const std::string& path_;
  std::uint32_t allowed_;
};

}  // namespace

std::uint32_t decode_scratch_bound(const NodeRecord& node, std::uint64_t glb_bytes) {
  const std::uint64_t json = std::min(glb_bytes, kJsonMaxBytes);
  const std::uint64_t words = draco_scratch_words_most(node.triangle_count, node.vertex_count, glb_bytes);
  return scratch(node, json_scratch(json / kJsonBytesPerValue, json),
                 mesh_scratch(node.triangle_count, node.vertex_count, words), node.vertex_count);
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
