// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/generate/glb_writer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <string_view>
#include <unordered_map>

namespace zc::generate {
namespace {

static_assert(std::endian::native == std::endian::little, "GLB is little-endian");

constexpr std::uint32_t kChunkJson = 0x4E4F534A;
constexpr std::uint32_t kChunkBin = 0x004E4942;

using Position = std::array<float, 3>;

struct PositionHash {
  std::size_t operator()(const Position& p) const {
    std::uint64_t h = 0;
    for (const float f : p) h = (h ^ std::bit_cast<std::uint32_t>(f)) * 0x9E3779B97F4A7C15ULL;
    return static_cast<std::size_t>(h ^ (h >> 29U));
  }
};

// City z up to glTF y up. Adding zero turns -0 into 0, which would not weld with it.
Position to_gltf(Vec3 p) {
  return {static_cast<float>(p.x) + 0.0F, static_cast<float>(p.z) + 0.0F, static_cast<float>(-p.y) + 0.0F};
}

std::string json_triple(const Position& p) { return nlohmann::json(p).dump(); }

template <class T>
void append(std::vector<std::byte>& out, std::span<T> values) {
  const std::span<const std::byte> bytes = std::as_bytes(values);
  out.insert(out.end(), bytes.begin(), bytes.end());
}

void append_u32(std::vector<std::byte>& out, std::uint64_t value) {
  const auto word = static_cast<std::uint32_t>(value);
  append(out, std::span(&word, 1));
}

}  // namespace

void GlbWriter::add(const MeshBuilder& mesh) {
  const std::span<const MeshTriangle> triangles = mesh.triangles();
  if (triangles.empty()) return;
  const std::uint64_t first_position = positions_.size();
  std::unordered_map<Position, std::uint32_t, PositionHash> welded;  // looked up only, never walked
  welded.reserve(triangles.size());
  Position low;
  Position high;
  low.fill(std::numeric_limits<float>::max());
  high.fill(std::numeric_limits<float>::lowest());
  std::vector<std::pair<Mat, std::array<std::uint32_t, 3>>> faces;
  faces.reserve(triangles.size());
  for (const MeshTriangle& t : triangles) {
    std::array<std::uint32_t, 3> face{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Position p = to_gltf(t.corners[k]);
      const auto [it, fresh] = welded.try_emplace(p, static_cast<std::uint32_t>(welded.size()));
      if (fresh) {
        positions_.insert(positions_.end(), p.begin(), p.end());
        for (std::size_t axis = 0; axis < 3; ++axis) {
          low[axis] = std::min(low[axis], p[axis]);
          high[axis] = std::max(high[axis], p[axis]);
        }
      }
      face[k] = it->second;
    }
    faces.emplace_back(t.material, face);
  }
  std::stable_sort(faces.begin(), faces.end(), [](const auto& a, const auto& b) { return a.first < b.first; });

  const auto comma = [](std::string& list) -> std::string& { return list.empty() ? list : list += ','; };
  const std::uint64_t position_accessor = accessor_count_++;
  comma(accessors_) += R"({"bufferView":0,"byteOffset":)" + std::to_string(first_position * sizeof(float)) +
                       R"(,"componentType":5126,"count":)" + std::to_string(welded.size()) +
                       R"(,"type":"VEC3","min":)" + json_triple(low) + R"(,"max":)" + json_triple(high) + "}";
  std::string primitives;
  for (std::size_t begin = 0; begin < faces.size();) {
    std::size_t end = begin;
    const std::uint64_t first_index = indices_.size();
    for (; end < faces.size() && faces[end].first == faces[begin].first; ++end) {
      indices_.insert(indices_.end(), faces[end].second.begin(), faces[end].second.end());
    }
    comma(accessors_) += R"({"bufferView":1,"byteOffset":)" + std::to_string(first_index * sizeof(std::uint32_t)) +
                         R"(,"componentType":5125,"count":)" + std::to_string(3 * (end - begin)) +
                         R"(,"type":"SCALAR"})";
    comma(primitives) += R"({"attributes":{"POSITION":)" + std::to_string(position_accessor) + R"(},"indices":)" +
                         std::to_string(accessor_count_++) + R"(,"material":)" +
                         std::to_string(static_cast<unsigned>(faces[begin].first)) + "}";
    begin = end;
  }
  const std::string name = nlohmann::json(mesh.name()).dump();
  comma(meshes_) += R"({"name":)" + name + R"(,"primitives":[)" + primitives + "]}";
  comma(nodes_) += R"({"name":)" + name + R"(,"mesh":)" + std::to_string(objects_) + "}";
  ++objects_;
  triangles_ += triangles.size();
}

Result<std::vector<std::byte>> GlbWriter::finish() {
  const std::uint64_t position_bytes = positions_.size() * sizeof(float);
  const std::uint64_t index_bytes = indices_.size() * sizeof(std::uint32_t);
  const std::uint64_t bin_bytes = position_bytes + index_bytes;

  nlohmann::ordered_json materials = nlohmann::ordered_json::array();
  for (const Material& m : city_materials()) {
    materials.push_back({{"name", m.name},
                         {"pbrMetallicRoughness",
                          {{"baseColorFactor", {m.base_color.x, m.base_color.y, m.base_color.z, 1}},
                           {"metallicFactor", m.metallic},
                           {"roughnessFactor", m.roughness}}}});
  }
  std::string json = R"({"asset":{"version":"2.0","generator":"zonecast generate"},"scene":0,"scenes":[{"nodes":[)";
  for (std::uint64_t i = 0; i < objects_; ++i) {
    if (i > 0) json += ',';
    json += std::to_string(i);
  }
  json += R"(]}],"nodes":[)" + nodes_ + R"(],"meshes":[)" + meshes_ + R"(],"materials":)" + materials.dump() +
          R"(,"accessors":[)" + accessors_ + R"(],"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":)" +
          std::to_string(position_bytes) + R"(,"byteStride":12,"target":34962},{"buffer":0,"byteOffset":)" +
          std::to_string(position_bytes) + R"(,"byteLength":)" + std::to_string(index_bytes) +
          R"(,"target":34963}],"buffers":[{"byteLength":)" + std::to_string(bin_bytes) + "}]}";
  json.resize((json.size() + 3) / 4 * 4, ' ');

  const std::uint64_t total = 12 + 8 + json.size() + 8 + bin_bytes;
  if (total > std::numeric_limits<std::uint32_t>::max()) {
    return Error{ErrorCode::kUnsupported, "a city of " + std::to_string(triangles_) + " triangles needs " +
                                              std::to_string(total) + " bytes, more than a GLB's 4 GiB"};
  }
  std::vector<std::byte> out;
  out.reserve(total);
  append(out, std::span(std::string_view("glTF")));
  append_u32(out, 2);
  append_u32(out, total);
  append_u32(out, json.size());
  append_u32(out, kChunkJson);
  append(out, std::span(json));
  append_u32(out, bin_bytes);
  append_u32(out, kChunkBin);
  append(out, std::span(positions_));
  append(out, std::span(indices_));
  *this = {};
  return out;
}

}  // namespace zc::generate
