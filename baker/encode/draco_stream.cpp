// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/encode/draco_stream.h"

#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <compare>
#include <cstring>
#include <exception>
#include <optional>
#include <span>

#include "streamer/draco/layout.h"
#include "streamer/draco/mesh.h"

namespace zc {
namespace {

struct Way {
  int method;
  int speed;  // of 0 (smallest) to 10
  bool predict_colors;
};
// The smallest is kept that the streamer reads. Below speed 5 predicted colours may be of symbols without a length.
// Below 3 little is saved.
constexpr std::array<Way, 4> kWays = {{{draco::MESH_EDGEBREAKER_ENCODING, 3, true},
                                       {draco::MESH_EDGEBREAKER_ENCODING, 3, false},
                                       {draco::MESH_EDGEBREAKER_ENCODING, 5, true},
                                       {draco::MESH_EDGEBREAKER_ENCODING, 5, false}}};
// At a vertex of n triangles edgebreaker goes through n^2 pairs of edges. In all, at most:
constexpr std::uint64_t kPairsLimit = 1U << 28U;
constexpr Way kLastResort = {draco::MESH_SEQUENTIAL_ENCODING, 3, true};

using Corner = std::array<std::uint16_t, 3>;

struct Face {
  std::array<Corner, 3> corners;  // the least first
  Rgb8 color = {};
  std::uint32_t index = 0;

  [[nodiscard]] bool looks_like(const Face& o) const { return corners == o.corners && color == o.color; }
  auto operator<=>(const Face&) const = default;
};

Face canonical(std::array<Corner, 3> corners, const Rgb8& color, std::uint32_t index) {
  std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
  return {corners, color, index};
}

std::vector<Face> canonical_faces(const QuantizedTriangles& mesh) {
  std::vector<Face> out;
  out.reserve(mesh.triangles.size());
  for (const auto& t : mesh.triangles)
    out.push_back(canonical({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]},
                            mesh.colors.empty() ? Rgb8{} : mesh.colors[out.size()],
                            static_cast<std::uint32_t>(out.size())));
  std::ranges::sort(out);
  return out;
}

std::uint64_t pairs_of_edges(const QuantizedTriangles& mesh) {
  std::vector<std::uint64_t> triangles_at(mesh.vertices.size());
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t v : triangle) ++triangles_at[v];
  std::uint64_t pairs = 0;
  for (const std::uint64_t n : triangles_at) pairs += n * n;
  return pairs;
}

// A point per corner, which become one where position and colour are the same.
void to_draco(const QuantizedTriangles& mesh, draco::Mesh& out) {
  const auto corners = static_cast<std::uint32_t>(3 * mesh.triangles.size());
  out.set_num_points(corners);
  out.SetNumFaces(mesh.triangles.size());
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i)
    out.SetFace(draco::FaceIndex(i),
                {draco::PointIndex(3 * i), draco::PointIndex(3 * i + 1), draco::PointIndex(3 * i + 2)});
  // Colours come first: what can be followed through a stream of two attributes is a stream whose first one has a
  // length, and that of colours mostly does.
  if (!mesh.colors.empty()) {
    std::vector<Rgb8> palette = mesh.colors;
    std::ranges::sort(palette);
    palette.erase(std::unique(palette.begin(), palette.end()), palette.end());
    draco::GeometryAttribute color;
    color.Init(draco::GeometryAttribute::COLOR, nullptr, 3, draco::DT_UINT8, true, sizeof(Rgb8), 0);
    draco::PointAttribute& values =
        *out.attribute(out.AddAttribute(color, false, static_cast<std::uint32_t>(palette.size())));
    for (std::uint32_t i = 0; i < palette.size(); ++i)
      values.SetAttributeValue(draco::AttributeValueIndex(i), palette[i].data());
    for (std::uint32_t c = 0; c < corners; ++c) {
      const auto found = std::ranges::lower_bound(palette, mesh.colors[c / 3]) - palette.begin();
      values.SetPointMapEntry(draco::PointIndex(c), draco::AttributeValueIndex(static_cast<std::uint32_t>(found)));
    }
  }
  draco::GeometryAttribute position;
  position.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_UINT16, false, sizeof(Corner), 0);
  draco::PointAttribute& values =
      *out.attribute(out.AddAttribute(position, false, static_cast<std::uint32_t>(mesh.vertices.size())));
  for (std::uint32_t i = 0; i < mesh.vertices.size(); ++i)
    values.SetAttributeValue(draco::AttributeValueIndex(i), mesh.vertices[i].data());
  for (std::uint32_t c = 0; c < corners; ++c)
    values.SetPointMapEntry(draco::PointIndex(c), draco::AttributeValueIndex(mesh.triangles[c / 3][c % 3]));
  out.DeduplicatePointIds();
}

// Empty when there is no such stream.
std::vector<std::byte> try_encode(const draco::Mesh& mesh, const Way& way) {
  draco::ExpertEncoder encoder(mesh);
  encoder.SetSpeedOptions(way.speed, way.speed);
  encoder.SetEncodingMethod(way.method);
  const int position_id = mesh.GetNamedAttributeId(draco::GeometryAttribute::POSITION);
  if (way.method == draco::MESH_EDGEBREAKER_ENCODING &&
      !encoder.SetAttributePredictionScheme(position_id, draco::MESH_PREDICTION_CONSTRAINED_MULTI_PARALLELOGRAM).ok())
    return {};
  const int color_id = mesh.GetNamedAttributeId(draco::GeometryAttribute::COLOR);
  if (color_id >= 0 && !way.predict_colors &&
      !encoder.SetAttributePredictionScheme(color_id, draco::PREDICTION_NONE).ok())
    return {};
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeToBuffer(&buffer).ok()) return {};
  std::vector<std::byte> bytes(buffer.size());
  std::memcpy(bytes.data(), buffer.data(), buffer.size());
  return bytes;
}

// Whether the streamer's decoder gives what draco gives.
bool reads_alike(std::span<const std::byte> bytes, const draco::Mesh& mesh, const draco::PointAttribute& position) {
  DracoLayout layout;
  if (read_draco_layout(bytes, position.unique_id(), layout) != nullptr || layout.values != position.size() ||
      layout.faces != mesh.num_faces())
    return false;
  std::vector<Corner> vertices(layout.values);
  std::vector<std::array<std::uint32_t, 3>> triangles(layout.faces);
  std::vector<std::uint32_t> words(layout.scratch_words());
  if (!decode_draco(layout, vertices, triangles, words)) return false;
  for (draco::AttributeValueIndex v(0); v < layout.values; ++v) {
    Corner vertex{};
    position.GetValue(v, vertex.data());
    if (vertex != vertices[v.value()]) return false;
  }
  for (draco::FaceIndex f(0); f < layout.faces; ++f)
    for (std::size_t k = 0; k < 3; ++k)
      if (position.mapped_index(mesh.face(f)[k]).value() != triangles[f.value()][k]) return false;
  return true;
}

// Nothing when the stream does not give `expected` back, to draco and to the streamer.
std::optional<DracoStream> read_back(const std::vector<std::byte>& bytes, const std::vector<Face>& expected) {
  draco::DecoderBuffer input;
  input.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&input);
  if (!decoded.ok()) return std::nullopt;
  const draco::Mesh& back = *decoded.value();
  const draco::PointAttribute* position = back.GetNamedAttribute(draco::GeometryAttribute::POSITION);
  if (position == nullptr || position->data_type() != draco::DT_UINT16) return std::nullopt;
  const draco::PointAttribute* color = back.GetNamedAttribute(draco::GeometryAttribute::COLOR);
  if (color != nullptr && color->data_type() != draco::DT_UINT8) return std::nullopt;
  if (!reads_alike(bytes, back, *position)) return std::nullopt;

  DracoStream out;
  out.bytes = bytes;
  out.position_id = position->unique_id();
  if (color != nullptr) out.color_id = color->unique_id();
  out.point_count = back.num_points();
  out.min = {65535, 65535, 65535};
  std::vector<Face> result;
  for (draco::FaceIndex f(0); f < back.num_faces(); ++f) {
    std::array<Corner, 3> corners{};
    Rgb8 rgb{};
    for (std::size_t k = 0; k < 3; ++k) {
      position->GetMappedValue(back.face(f)[k], corners[k].data());
      for (std::size_t axis = 0; axis < 3; ++axis) {
        out.min[axis] = std::min(out.min[axis], corners[k][axis]);
        out.max[axis] = std::max(out.max[axis], corners[k][axis]);
      }
    }
    if (color != nullptr) color->GetMappedValue(back.face(f)[0], rgb.data());
    result.push_back(canonical(corners, rgb, f.value()));
  }
  std::ranges::sort(result);
  if (!std::ranges::equal(result, expected, &Face::looks_like)) return std::nullopt;
  out.order.resize(result.size());
  for (std::size_t i = 0; i < result.size(); ++i) out.order[result[i].index] = expected[i].index;
  return out;
}

}  // namespace

Result<DracoStream> encode_draco(const QuantizedTriangles& mesh) {
  if (mesh.triangles.empty()) return Error{ErrorCode::kFormat, "no triangles to compress"};
  try {
    draco::Mesh source;
    to_draco(mesh, source);
    const std::vector<Face> expected = canonical_faces(mesh);
    std::vector<std::vector<std::byte>> streams;
    if (pairs_of_edges(mesh) <= kPairsLimit)
      for (const Way& way : kWays)
        if (way.predict_colors || !mesh.colors.empty()) streams.push_back(try_encode(source, way));
    std::ranges::stable_sort(streams, {}, &std::vector<std::byte>::size);
    if (mesh.colors.empty()) streams.push_back(try_encode(source, kLastResort));
    for (const std::vector<std::byte>& bytes : streams)
      if (!bytes.empty())
        if (auto stream = read_back(bytes, expected)) return *std::move(stream);
  } catch (const std::exception& exception) {
    return Error{ErrorCode::kFormat, std::string("Draco: ") + exception.what()};
  }
  return Error{ErrorCode::kFormat, "Draco does not give the triangles of a zone back"};
}

}  // namespace zc
