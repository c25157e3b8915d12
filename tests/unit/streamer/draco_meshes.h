// SPDX-License-Identifier: Apache-2.0
// Meshes that are hard to connect, as Draco streams, and what libdraco makes of them. The same seed gives the same.
#pragma once

#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <random>
#include <string>
#include <vector>

namespace zc::test {

struct HardMesh {
  std::string name;
  std::vector<std::array<std::uint16_t, 3>> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

class HardMeshes {
 public:
  explicit HardMeshes(std::uint32_t seed) : random_(seed) {}

  std::vector<HardMesh> all() {
    std::vector<HardMesh> out;
    out.push_back(make("one", 3, {{0, 1, 2}}));
    out.push_back(make("pillow", 3, {{0, 1, 2}, {0, 2, 1}}));
    out.push_back(make("tetrahedron", 4, {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}}));
    for (const std::uint32_t size : {2U, 7U, 25U, 60U}) out.push_back(grid("grid", size, false, false, 0));
    for (const std::uint32_t size : {3U, 9U, 40U}) out.push_back(grid("tube", size, true, false, 0));
    for (const std::uint32_t size : {3U, 8U, 36U}) out.push_back(grid("torus", size, true, true, 0));
    for (const std::uint32_t holes : {2U, 5U, 9U}) {
      out.push_back(grid("torn torus", 30, true, true, holes));
      out.push_back(grid("torn grid", 40, false, false, holes));
    }
    for (const std::uint32_t handles : {1U, 4U, 20U}) out.push_back(with_handles(handles));
    for (const std::uint32_t count : {5U, 100U, 2000U}) out.push_back(soup(count, 3 * count));
    for (const std::uint32_t count : {30U, 400U, 3000U}) out.push_back(soup(count, count / 3));  // edges of many faces
    out.push_back(soup(300, 12));
    for (const std::uint32_t faces : {3U, 7U, 200U}) out.push_back(fan(faces));
    out.push_back(many_parts(300));
    out.push_back(soup(25'000, 75'000));  // more than 16 bits of vertices
    return out;
  }

 private:
  HardMesh make(std::string name, std::uint32_t vertices, std::vector<std::array<std::uint32_t, 3>> triangles) {
    HardMesh mesh{std::move(name), {}, std::move(triangles)};
    for (std::uint32_t v = 0; v < vertices; ++v) mesh.vertices.push_back(anywhere());
    return mesh;
  }

  // size × size cells; its ends may meet, and one of so many cells may be missing.
  HardMesh grid(std::string name, std::uint32_t size, bool closed_x, bool closed_y, std::uint32_t torn) {
    HardMesh mesh{std::move(name), {}, {}};
    const std::uint32_t wide = closed_x ? size : size + 1;
    const std::uint32_t high = closed_y ? size : size + 1;
    for (std::uint32_t y = 0; y < high; ++y)
      for (std::uint32_t x = 0; x < wide; ++x)
        mesh.vertices.push_back({static_cast<std::uint16_t>(600 * x + random_() % 90),
                                 static_cast<std::uint16_t>(600 * y + random_() % 90),
                                 static_cast<std::uint16_t>(random_() % 700)});
    const auto at = [&](std::uint32_t x, std::uint32_t y) { return y % high * wide + x % wide; };
    for (std::uint32_t y = 0; y < size; ++y)
      for (std::uint32_t x = 0; x < size; ++x) {
        if (torn > 0 && random_() % torn == 0) continue;
        mesh.triangles.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
        if (torn == 0 || random_() % 9 != 0) mesh.triangles.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
      }
    return mesh;
  }

  // A plate of two sides with tunnels through it.
  HardMesh with_handles(std::uint32_t handles) {
    const std::uint32_t size = 6 * handles + 3;
    HardMesh mesh = grid("handles", size, false, false, 0);
    const auto side = static_cast<std::uint32_t>(mesh.vertices.size());
    for (std::uint32_t v = 0; v < side; ++v) {
      auto below = mesh.vertices[v];
      below[2] = static_cast<std::uint16_t>(below[2] + 3000);
      mesh.vertices.push_back(below);
    }
    mesh.triangles.clear();
    const auto at = [&](std::uint32_t x, std::uint32_t y) { return y * (size + 1) + x; };
    const auto is_hole = [&](std::uint32_t x, std::uint32_t y) { return x % 6 == 3 && y == size / 2; };
    const auto wall = [&](std::uint32_t a, std::uint32_t b) {
      mesh.triangles.push_back({a, b, b + side});
      mesh.triangles.push_back({a, b + side, a + side});
    };
    for (std::uint32_t y = 0; y < size; ++y)
      for (std::uint32_t x = 0; x < size; ++x) {
        const std::array<std::uint32_t, 4> corner = {at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)};
        if (is_hole(x, y)) {
          for (std::size_t i = 0; i < 4; ++i) wall(corner[i], corner[(i + 1) % 4]);
          continue;
        }
        mesh.triangles.push_back({corner[0], corner[1], corner[2]});
        mesh.triangles.push_back({corner[0], corner[2], corner[3]});
        mesh.triangles.push_back({corner[0] + side, corner[2] + side, corner[1] + side});
        mesh.triangles.push_back({corner[0] + side, corner[3] + side, corner[2] + side});
      }
    return mesh;
  }

  HardMesh soup(std::uint32_t triangles, std::uint32_t vertices) {
    HardMesh mesh = make("soup", vertices, {});
    while (mesh.triangles.size() < triangles) {
      const std::array<std::uint32_t, 3> t = {below(vertices), below(vertices), below(vertices)};
      if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) mesh.triangles.push_back(t);
    }
    return mesh;
  }

  // All on one edge.
  HardMesh fan(std::uint32_t faces) {
    HardMesh mesh = make("fan", faces + 2, {});
    for (std::uint32_t i = 0; i < faces; ++i)
      mesh.triangles.push_back(i % 3 == 0 ? std::array{0U, 1U, i + 2} : std::array{1U, 0U, i + 2});
    return mesh;
  }

  HardMesh many_parts(std::uint32_t parts) {
    HardMesh mesh{"parts", {}, {}};
    for (std::uint32_t i = 0; i < parts; ++i) {
      const HardMesh part = i % 5 == 0 ? grid("", 4, true, true, 0) : grid("", 1 + i % 3, false, i % 2 == 0, i % 4);
      const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
      mesh.vertices.insert(mesh.vertices.end(), part.vertices.begin(), part.vertices.end());
      for (const auto& t : part.triangles) {
        if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
        mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
      }
    }
    return mesh;
  }

  std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(random_() % n); }
  std::array<std::uint16_t, 3> anywhere() {
    return {static_cast<std::uint16_t>(random_()), static_cast<std::uint16_t>(random_()),
            static_cast<std::uint16_t>(random_())};
  }

  std::mt19937 random_;
};

enum class Colors : std::uint8_t { kNone, kPredicted, kPlain };
struct DracoWay {
  bool edgebreaker = true;
  int speed = 3;
  Colors colors = Colors::kNone;
  bool few_parallelograms = false;  // predictions from one at most
  bool coded_indices = false;       // of sequential streams
};

// Empty where draco does not take the mesh.
inline std::vector<std::byte> draco_stream(const HardMesh& mesh, const DracoWay& way) {
  const auto corners = static_cast<std::uint32_t>(3 * mesh.triangles.size());
  draco::Mesh out;
  out.set_num_points(corners);
  out.SetNumFaces(mesh.triangles.size());
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i)
    out.SetFace(draco::FaceIndex(i),
                {draco::PointIndex(3 * i), draco::PointIndex(3 * i + 1), draco::PointIndex(3 * i + 2)});
  if (way.colors != Colors::kNone) {
    draco::GeometryAttribute color;
    color.Init(draco::GeometryAttribute::COLOR, nullptr, 3, draco::DT_UINT8, true, 3, 0);
    draco::PointAttribute& values = *out.attribute(out.AddAttribute(color, false, 6));
    for (std::uint32_t i = 0; i < 6; ++i) {
      const std::array<std::uint8_t, 3> rgb = {static_cast<std::uint8_t>(40 * i),
                                               static_cast<std::uint8_t>(250 - 9 * i), static_cast<std::uint8_t>(i)};
      values.SetAttributeValue(draco::AttributeValueIndex(i), rgb.data());
    }
    for (std::uint32_t c = 0; c < corners; ++c)
      values.SetPointMapEntry(draco::PointIndex(c), draco::AttributeValueIndex(c / 3 / 5 * 5 % 6));
  }
  draco::GeometryAttribute position;
  position.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_UINT16, false, 6, 0);
  const int id = out.AddAttribute(position, false, static_cast<std::uint32_t>(mesh.vertices.size()));
  draco::PointAttribute& values = *out.attribute(id);
  for (std::uint32_t i = 0; i < mesh.vertices.size(); ++i)
    values.SetAttributeValue(draco::AttributeValueIndex(i), mesh.vertices[i].data());
  for (std::uint32_t c = 0; c < corners; ++c)
    values.SetPointMapEntry(draco::PointIndex(c), draco::AttributeValueIndex(mesh.triangles[c / 3][c % 3]));
  out.DeduplicatePointIds();
  draco::ExpertEncoder encoder(out);
  encoder.SetSpeedOptions(way.speed, way.speed);
  encoder.options().SetGlobalBool("compress_connectivity", way.coded_indices);
  encoder.SetEncodingMethod(way.edgebreaker ? draco::MESH_EDGEBREAKER_ENCODING : draco::MESH_SEQUENTIAL_ENCODING);
  if (way.edgebreaker && !encoder
                              .SetAttributePredictionScheme(
                                  id, way.few_parallelograms ? draco::MESH_PREDICTION_PARALLELOGRAM
                                                             : draco::MESH_PREDICTION_CONSTRAINED_MULTI_PARALLELOGRAM)
                              .ok())
    return {};
  if (way.colors == Colors::kPlain && !encoder.SetAttributePredictionScheme(0, draco::PREDICTION_NONE).ok()) return {};
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeToBuffer(&buffer).ok()) return {};
  std::vector<std::byte> bytes(buffer.size());
  std::memcpy(bytes.data(), buffer.data(), buffer.size());
  return bytes;
}

// As libdraco reads it: positions in the order of their values, and the triangles by value.
struct DracoReading {
  bool ok = false;
  std::uint32_t position_id = 0;
  std::vector<std::array<std::uint16_t, 3>> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};
inline DracoReading read_with_draco(const std::vector<std::byte>& stream) {
  draco::DecoderBuffer input;
  input.Init(reinterpret_cast<const char*>(stream.data()), stream.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&input);
  DracoReading out;
  if (!decoded.ok()) return out;
  const draco::Mesh& mesh = *decoded.value();
  const draco::PointAttribute& position = *mesh.GetNamedAttribute(draco::GeometryAttribute::POSITION);
  out.ok = true;
  out.position_id = position.unique_id();
  out.vertices.resize(position.size());
  for (std::uint32_t v = 0; v < out.vertices.size(); ++v)
    position.GetValue(draco::AttributeValueIndex(v), out.vertices[v].data());
  out.triangles.resize(mesh.num_faces());
  for (std::uint32_t f = 0; f < out.triangles.size(); ++f)
    for (std::size_t k = 0; k < 3; ++k)
      out.triangles[f][k] = position.mapped_index(mesh.face(draco::FaceIndex(f))[k]).value();
  return out;
}

}  // namespace zc::test
