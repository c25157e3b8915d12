// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/draco_stream.h"

#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <optional>

namespace zc {
namespace {

constexpr int kSpeed = 3;  // of 0 (smallest) to 10

using Corner = std::array<std::uint16_t, 3>;
using Triangle = std::array<Corner, 3>;

Triangle canonical(Triangle t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

std::vector<Triangle> canonical_triangles(const QuantizedTriangles& mesh) {
  std::vector<Triangle> out;
  out.reserve(mesh.triangles.size());
  for (const auto& t : mesh.triangles)
    out.push_back(canonical({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]}));
  std::sort(out.begin(), out.end());
  return out;
}

void to_draco(const QuantizedTriangles& mesh, draco::Mesh& out) {
  out.set_num_points(static_cast<std::uint32_t>(mesh.vertices.size()));
  draco::GeometryAttribute position;
  position.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_UINT16, false, 3 * sizeof(std::uint16_t), 0);
  const int attribute = out.AddAttribute(position, true, static_cast<std::uint32_t>(mesh.vertices.size()));
  for (std::uint32_t i = 0; i < mesh.vertices.size(); ++i)
    out.attribute(attribute)->SetAttributeValue(draco::AttributeValueIndex(i), mesh.vertices[i].data());
  out.SetNumFaces(mesh.triangles.size());
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    out.SetFace(draco::FaceIndex(i), {draco::PointIndex(t[0]), draco::PointIndex(t[1]), draco::PointIndex(t[2])});
  }
}

// Empty when the stream cannot be written or does not give `expected` back.
std::optional<DracoStream> try_encode(const draco::Mesh& mesh, int method, const std::vector<Triangle>& expected) {
  draco::ExpertEncoder encoder(mesh);
  encoder.SetSpeedOptions(kSpeed, kSpeed);
  encoder.SetEncodingMethod(method);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeToBuffer(&buffer).ok()) return std::nullopt;

  draco::DecoderBuffer input;
  input.Init(buffer.data(), buffer.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&input);
  if (!decoded.ok()) return std::nullopt;
  const draco::Mesh& back = *decoded.value();
  const draco::PointAttribute* position = back.GetNamedAttribute(draco::GeometryAttribute::POSITION);
  if (position == nullptr || position->data_type() != draco::DT_UINT16) return std::nullopt;

  DracoStream out;
  out.attribute_id = position->unique_id();
  out.vertex_count = back.num_points();
  out.min = {65535, 65535, 65535};
  QuantizedTriangles result;
  for (draco::PointIndex p(0); p < back.num_points(); ++p) {
    Corner value = {};
    position->GetMappedValue(p, value.data());
    result.vertices.push_back(value);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      out.min[axis] = std::min(out.min[axis], value[axis]);
      out.max[axis] = std::max(out.max[axis], value[axis]);
    }
  }
  for (draco::FaceIndex f(0); f < back.num_faces(); ++f) {
    const auto& face = back.face(f);
    result.triangles.push_back({face[0].value(), face[1].value(), face[2].value()});
  }
  if (canonical_triangles(result) != expected) return std::nullopt;
  out.bytes.resize(buffer.size());
  std::memcpy(out.bytes.data(), buffer.data(), buffer.size());
  return out;
}

}  // namespace

Result<DracoStream> encode_draco(const QuantizedTriangles& mesh) {
  if (mesh.triangles.empty()) return Error{ErrorCode::kFormat, "no triangles to compress"};
  try {
    draco::Mesh source;
    to_draco(mesh, source);
    const std::vector<Triangle> expected = canonical_triangles(mesh);
    for (const int method : {draco::MESH_EDGEBREAKER_ENCODING, draco::MESH_SEQUENTIAL_ENCODING})
      if (auto stream = try_encode(source, method, expected)) return *std::move(stream);
  } catch (const std::exception& exception) {
    return Error{ErrorCode::kFormat, std::string("Draco: ") + exception.what()};
  }
  return Error{ErrorCode::kFormat, "Draco does not give the triangles of a zone back"};
}

}  // namespace zc
