// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/encode.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "baker/draco_stream.h"
#include "base/check.h"

namespace zc {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint32_t kUnsignedShort = 5123;
constexpr std::uint32_t kUnsignedInt = 5125;

// The faces of one material, offset from the origin, in the order of the mesh.
QuantizedTriangles quantize(const LatticeMesh& mesh, std::uint16_t material, const LatticePoint& origin,
                            std::uint32_t step_shift) {
  QuantizedTriangles out;
  std::vector<std::uint32_t> target(mesh.vertices.size(), UINT32_MAX);
  for (const auto& face : mesh.faces) {
    if (face.material != material) continue;
    std::array<std::uint32_t, 3> triangle = {};
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint32_t& index = target[face.v[k]];
      if (index == UINT32_MAX) {
        index = static_cast<std::uint32_t>(out.vertices.size());
        std::array<std::uint16_t, 3> q = {};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const std::int64_t offset = std::int64_t{mesh.vertices[face.v[k]][axis]} - origin[axis];
          ZC_CHECK(offset >= 0 && (offset >> step_shift) <= 65535 && (offset >> step_shift) << step_shift == offset);
          q[axis] = static_cast<std::uint16_t>(offset >> step_shift);
        }
        out.vertices.push_back(q);
      }
      triangle[k] = index;
    }
    out.triangles.push_back(triangle);
  }
  return out;
}

void append_word(std::vector<std::byte>& out, std::uint32_t value) {
  const std::size_t at = out.size();
  out.resize(at + sizeof value);
  std::memcpy(out.data() + at, &value, sizeof value);
}

std::vector<std::byte> make_glb(std::string json, std::vector<std::byte> bin) {
  while (json.size() % 4 != 0) json.push_back(' ');
  while (bin.size() % 4 != 0) bin.push_back(std::byte{0});
  std::vector<std::byte> out;
  out.reserve(28 + json.size() + bin.size());
  append_word(out, 0x46546C67);  // "glTF"
  append_word(out, 2);
  append_word(out, static_cast<std::uint32_t>(28 + json.size() + bin.size()));
  append_word(out, static_cast<std::uint32_t>(json.size()));
  append_word(out, 0x4E4F534A);  // "JSON"
  const auto* text = reinterpret_cast<const std::byte*>(json.data());
  out.insert(out.end(), text, text + json.size());
  append_word(out, static_cast<std::uint32_t>(bin.size()));
  append_word(out, 0x004E4942);  // "BIN"
  out.insert(out.end(), bin.begin(), bin.end());
  return out;
}

// Six digits are below what a display shows, and keep the JSON short.
double short_number(float value) { return std::round(static_cast<double>(value) * 1e6) / 1e6; }

Json material_json(const Material& material, std::uint16_t index) {
  return {{"pbrMetallicRoughness",
           {{"baseColorFactor",
             {short_number(material.base_color.r), short_number(material.base_color.g),
              short_number(material.base_color.b), 1}},
            {"metallicFactor", short_number(material.metallic)},
            {"roughnessFactor", short_number(material.roughness)}}},
          {"doubleSided", true},
          {"extras", {{"zonecast_material", index}}}};
}

// Lattice x, y, z (z up) to glTF metres x, z, -y (y up).
Json node_matrix(const LatticePoint& origin, std::uint32_t step_shift, double step_m) {
  const double s = std::ldexp(step_m, static_cast<int>(step_shift));
  const auto metres = [&](std::size_t axis) { return origin[axis] * step_m; };
  return {s, 0, 0, 0, 0, 0, -s, 0, 0, s, 0, 0, metres(0), metres(2), 0.0 - metres(1), 1};
}

}  // namespace

Result<EncodedZone> encode_zone_glb(const LatticeMesh& mesh, std::uint32_t step_shift,
                                    std::span<const Material> materials, double step_m) {
  EncodedZone out;
  const LatticeBox box = bounds_of(mesh);
  if (box.empty()) return Error{ErrorCode::kFormat, "a zone without triangles cannot be encoded"};
  for (std::size_t axis = 0; axis < 3; ++axis) out.origin[axis] = (box.min[axis] >> step_shift) << step_shift;
  out.bounds_min = box.min;
  out.bounds_max = box.max;

  std::vector<bool> used(materials.size(), false);
  for (const auto& face : mesh.faces) used.at(face.material) = true;
  Json accessors = Json::array();
  Json views = Json::array();
  Json primitives = Json::array();
  Json material_list = Json::array();
  std::vector<std::byte> bin;
  for (std::uint32_t m = 0; m < used.size(); ++m) {
    if (!used[m]) continue;
    const auto material = static_cast<std::uint16_t>(m);
    const QuantizedTriangles part = quantize(mesh, material, out.origin, step_shift);
    ZC_ASSIGN(const DracoStream stream, encode_draco(part));
    while (bin.size() % 4 != 0) bin.push_back(std::byte{0});
    primitives.push_back({{"attributes", {{"POSITION", accessors.size() + 1}}},
                          {"indices", accessors.size()},
                          {"material", material_list.size()},
                          {"extensions",
                           {{"KHR_draco_mesh_compression",
                             {{"bufferView", views.size()}, {"attributes", {{"POSITION", stream.attribute_id}}}}}}}});
    accessors.push_back({{"componentType", stream.vertex_count <= 65535 ? kUnsignedShort : kUnsignedInt},
                         {"count", 3 * part.triangles.size()},
                         {"type", "SCALAR"}});
    accessors.push_back({{"componentType", kUnsignedShort},
                         {"count", stream.vertex_count},
                         {"type", "VEC3"},
                         {"min", stream.min},
                         {"max", stream.max}});
    views.push_back({{"buffer", 0}, {"byteOffset", bin.size()}, {"byteLength", stream.bytes.size()}});
    material_list.push_back(material_json(materials[m], material));
    bin.insert(bin.end(), stream.bytes.begin(), stream.bytes.end());
    out.triangle_count += static_cast<std::uint32_t>(part.triangles.size());
    out.vertex_count += stream.vertex_count;
    ++out.primitive_count;
  }
  while (bin.size() % 4 != 0) bin.push_back(std::byte{0});
  const Json extensions = {"KHR_draco_mesh_compression", "KHR_mesh_quantization"};
  const Json json = {{"asset", {{"version", "2.0"}, {"generator", "zonecast"}}},
                     {"extensionsUsed", extensions},
                     {"extensionsRequired", extensions},
                     {"scene", 0},
                     {"scenes", Json::array({{{"nodes", {0}}}})},
                     {"nodes", Json::array({{{"mesh", 0}, {"matrix", node_matrix(out.origin, step_shift, step_m)}}})},
                     {"meshes", Json::array({{{"primitives", std::move(primitives)}}})},
                     {"materials", std::move(material_list)},
                     {"accessors", std::move(accessors)},
                     {"bufferViews", std::move(views)},
                     {"buffers", Json::array({{{"byteLength", bin.size()}}})}};
  out.glb = make_glb(json.dump(), std::move(bin));
  return out;
}

}  // namespace zc
