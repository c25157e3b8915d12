// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/encode/zone_glb.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <tuple>
#include <utility>

#include "baker/encode/draco_stream.h"
#include "base/check.h"

namespace zc {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint32_t kUnsignedByte = 5121;
constexpr std::uint32_t kUnsignedShort = 5123;
constexpr std::uint32_t kUnsignedInt = 5125;

// The faces of one part of a zone, offset from the origin, in the order of the mesh.
struct Part {
  QuantizedTriangles mesh;
  std::vector<std::uint32_t> faces;  // their numbers
  Rgb8 color = {255, 255, 255};      // of all, when the mesh has no colours of its own
};

class Quantizer {
 public:
  Quantizer(const LatticeMesh& mesh, const LatticePoint& origin, std::uint32_t step_shift)
      : mesh_(mesh), origin_(origin), step_shift_(step_shift) {}

  [[nodiscard]] Part run(std::vector<std::uint32_t> faces) const {
    Part part;
    std::map<std::array<std::uint16_t, 3>, std::uint32_t> number;
    for (const std::uint32_t f : faces) {
      std::array<std::uint32_t, 3> triangle = {};
      for (std::size_t k = 0; k < 3; ++k) {
        const auto q = quantized(mesh_.vertices[mesh_.faces[f].v[k]]);
        const auto [entry, fresh] = number.try_emplace(q, static_cast<std::uint32_t>(part.mesh.vertices.size()));
        if (fresh) part.mesh.vertices.push_back(q);
        triangle[k] = entry->second;
      }
      part.mesh.triangles.push_back(triangle);
    }
    part.faces = std::move(faces);
    return part;
  }

 private:
  [[nodiscard]] std::array<std::uint16_t, 3> quantized(const LatticePoint& p) const {
    std::array<std::uint16_t, 3> q = {};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::int64_t offset = std::int64_t{p[axis]} - origin_[axis];
      ZC_CHECK(offset >= 0 && (offset >> step_shift_) <= 65535 && (offset >> step_shift_) << step_shift_ == offset);
      q[axis] = static_cast<std::uint16_t>(offset >> step_shift_);
    }
    return q;
  }

  const LatticeMesh& mesh_;
  const LatticePoint& origin_;
  std::uint32_t step_shift_;
};

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

// 8192, not 8192.0. Origins and colours are far below 2^63.
Json number(double value) {
  const auto whole = static_cast<std::int64_t>(value);
  return static_cast<double>(whole) == value ? Json(whole) : Json(value);
}

// Six digits are below what a display shows, and keep the JSON short.
Json short_number(float value) { return number(std::round(static_cast<double>(value) * 1e6) / 1e6); }

// What viewers show: colours in 255ths of `brightest`, and of roughness and metalness those that most triangles have.
struct Appearances {
  std::array<float, 3> brightest = {};
  float roughness = 1;
  float metallic = 0;

  Appearances(const LatticeMesh& mesh, std::span<const Material> materials) {
    std::map<std::pair<float, float>, std::size_t> count;
    for (const auto& face : mesh.faces) {
      const Material& m = materials[face.material];
      brightest = {std::max(brightest[0], m.base_color.r), std::max(brightest[1], m.base_color.g),
                   std::max(brightest[2], m.base_color.b)};
      ++count[{m.roughness, m.metallic}];
    }
    const auto most = std::ranges::max_element(count, {}, [](const auto& entry) { return entry.second; });
    if (most != count.end()) std::tie(roughness, metallic) = most->first;
  }

  [[nodiscard]] Rgb8 color_of(const Material& m) const {
    const std::array<float, 3> color = {m.base_color.r, m.base_color.g, m.base_color.b};
    Rgb8 out{};
    for (std::size_t c = 0; c < 3; ++c)
      out[c] = brightest[c] > 0 ? static_cast<std::uint8_t>(std::lround(255 * color[c] / brightest[c])) : 0;
    return out;
  }
};

Json material_json(const Appearances& appearances, const Rgb8& color) {
  const auto factor = [&](std::size_t c) {
    return short_number(appearances.brightest[c] * static_cast<float>(color[c]) / 255);
  };
  return {{"pbrMetallicRoughness",
           {{"baseColorFactor", {factor(0), factor(1), factor(2), 1}},
            {"metallicFactor", short_number(appearances.metallic)},
            {"roughnessFactor", short_number(appearances.roughness)}}},
          {"doubleSided", true}};
}

// Lattice x, y, z (z up) to glTF metres x, z, -y (y up).
Json node_matrix(const LatticePoint& origin, std::uint32_t step_shift, double step_m) {
  const double s = std::ldexp(step_m, static_cast<int>(step_shift));
  const auto metres = [&](std::size_t axis, int sign) { return number(sign * (origin[axis] * step_m)); };
  return {s, 0, 0, 0, 0, 0, -s, 0, 0, s, 0, 0, metres(0, 1), metres(2, 1), metres(1, -1), 1};
}

// One part with its colours; where no such stream can be followed, a part for each colour.
Result<std::vector<std::pair<Part, DracoStream>>> encode_parts(const LatticeMesh& mesh,
                                                               std::span<const Material> materials,
                                                               const Appearances& appearances,
                                                               const Quantizer& quantizer) {
  std::map<Rgb8, std::vector<std::uint32_t>> faces_of;
  std::vector<Rgb8> colors;
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
    colors.push_back(appearances.color_of(materials[mesh.faces[f].material]));
    faces_of[colors.back()].push_back(f);
  }
  std::vector<std::pair<Part, DracoStream>> parts;
  if (faces_of.size() > 1) {
    std::vector<std::uint32_t> all(mesh.faces.size());
    std::iota(all.begin(), all.end(), 0U);
    Part part = quantizer.run(std::move(all));
    part.mesh.colors = std::move(colors);
    if (auto stream = encode_draco(part.mesh); stream.ok()) {
      parts.emplace_back(std::move(part), *std::move(stream));
      return parts;
    }
  }
  for (auto& [color, faces] : faces_of) {
    Part part = quantizer.run(std::move(faces));
    part.color = color;
    ZC_ASSIGN(DracoStream stream, encode_draco(part.mesh));
    parts.emplace_back(std::move(part), std::move(stream));
  }
  return parts;
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

  const Appearances appearances(mesh, materials);
  const Quantizer quantizer(mesh, out.origin, step_shift);
  ZC_ASSIGN(const auto parts, encode_parts(mesh, materials, appearances, quantizer));
  Json accessors = Json::array();
  Json views = Json::array();
  Json primitives = Json::array();
  Json material_list = Json::array();
  std::vector<std::byte> bin;
  for (const auto& [part, stream] : parts) {
    while (bin.size() % 4 != 0) bin.push_back(std::byte{0});
    Json attributes = {{"POSITION", accessors.size() + 1}};
    Json compressed = {{"POSITION", stream.position_id}};
    if (!part.mesh.colors.empty()) {
      attributes["COLOR_0"] = accessors.size() + 2;
      compressed["COLOR_0"] = stream.color_id;
    }
    primitives.push_back(
        {{"attributes", std::move(attributes)},
         {"indices", accessors.size()},
         {"material", material_list.size()},
         {"extensions",
          {{"KHR_draco_mesh_compression", {{"bufferView", views.size()}, {"attributes", std::move(compressed)}}}}}});
    accessors.push_back({{"componentType", stream.point_count <= 65535 ? kUnsignedShort : kUnsignedInt},
                         {"count", 3 * part.faces.size()},
                         {"type", "SCALAR"}});
    accessors.push_back({{"componentType", kUnsignedShort},
                         {"count", stream.point_count},
                         {"type", "VEC3"},
                         {"min", stream.min},
                         {"max", stream.max}});
    if (!part.mesh.colors.empty())
      accessors.push_back(
          {{"componentType", kUnsignedByte}, {"normalized", true}, {"count", stream.point_count}, {"type", "VEC3"}});
    views.push_back({{"buffer", 0}, {"byteLength", stream.bytes.size()}});
    if (!bin.empty()) views.back()["byteOffset"] = bin.size();
    material_list.push_back(material_json(appearances, part.color));
    bin.insert(bin.end(), stream.bytes.begin(), stream.bytes.end());
    out.draco_bytes += stream.bytes.size();
    out.triangle_count += static_cast<std::uint32_t>(part.faces.size());
    out.vertex_count += stream.point_count;
    ++out.primitive_count;
    for (const std::uint32_t t : stream.order) out.materials.push_back(mesh.faces[part.faces[t]].material);
  }
  while (bin.size() % 4 != 0) bin.push_back(std::byte{0});
  const Json extensions = {"KHR_draco_mesh_compression", "KHR_mesh_quantization"};
  const Json json = {{"asset", {{"version", "2.0"}}},
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
