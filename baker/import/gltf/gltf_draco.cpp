// SPDX-License-Identifier: GPL-3.0-or-later
// Draco bitstream 2.2 (google.github.io/draco/spec): header, then the connectivity's declared sizes, which decide how
// much memory the decoder takes and are therefore read here first.
#include <draco/compression/decode.h>
#include <draco/core/decoder_buffer.h>

#include "baker/import/gltf/gltf_geometry.h"
#include "baker/import/shared/json_text.h"

namespace zc {
namespace {

constexpr const char* kDraco = "KHR_draco_mesh_compression";
// The best streams of regular grids stay far below this many faces or points a byte.
constexpr std::uint64_t kMaxPerByte = 4096;

class Cursor {
 public:
  Cursor(std::span<const std::byte> bytes, std::size_t at) : bytes_(bytes), at_(at) {}
  std::uint8_t byte() {
    if (at_ >= bytes_.size()) {
      ok_ = false;
      return 0;
    }
    return static_cast<std::uint8_t>(bytes_[at_++]);
  }
  std::uint64_t varint() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 64 && ok_; shift += 7) {
      const std::uint8_t part = byte();
      value |= static_cast<std::uint64_t>(part & 0x7FU) << shift;
      if ((part & 0x80U) == 0) return value;
    }
    ok_ = false;
    return value;
  }
  [[nodiscard]] bool ok() const { return ok_; }

 private:
  std::span<const std::byte> bytes_;
  std::size_t at_;
  bool ok_ = true;
};

Status check_declared(std::span<const std::byte> bytes, const GltfFile& file, const std::string& where) {
  Cursor cursor(bytes, 0);
  for (const char expected : {'D', 'R', 'A', 'C', 'O'})
    if (cursor.byte() != static_cast<std::uint8_t>(expected)) return file.error(where + ": no Draco stream");
  const unsigned major = cursor.byte();
  const unsigned minor = cursor.byte();
  const unsigned type = cursor.byte();
  const unsigned method = cursor.byte();
  const unsigned flags = cursor.byte() | static_cast<unsigned>(cursor.byte()) << 8U;
  if (!cursor.ok()) return file.error(where + ": Draco header is cut short");
  if (major != 2 || minor != 2 || type != 1 || method > 1 || (flags & 0x8000U) != 0)
    return Error{ErrorCode::kUnsupported,
                 where + ": Draco stream " + std::to_string(major) + "." + std::to_string(minor) + " of type " +
                     std::to_string(type) + ((flags & 0x8000U) != 0 ? " with metadata" : "") +
                     ", only plain 2.2 meshes are read",
                 file.path};
  if (method == 1) cursor.byte();  // edgebreaker names its traversal first, then points before faces
  const std::uint64_t first = cursor.varint();
  const std::uint64_t second = cursor.varint();
  if (!cursor.ok()) return file.error(where + ": Draco stream is cut short");
  const std::uint64_t limit = kMaxPerByte * bytes.size();
  if (first > limit || second > limit)
    return file.error(where + ": Draco stream of " + std::to_string(bytes.size()) + " bytes declares " +
                      std::to_string(std::max(first, second)) + " faces or points");
  return {};
}

// Of every point. The primitive's accessor gives the meaning of Draco's integers.
template <int kComponents>
Result<std::vector<std::array<double, kComponents>>> read_attribute(const GltfFile& file,
                                                                    const tinygltf::Primitive& primitive,
                                                                    const std::string& name, int unique_id,
                                                                    draco::Mesh& mesh, const std::string& where) {
  int component_type = TINYGLTF_COMPONENT_TYPE_FLOAT;
  bool normalized = false;
  if (const auto named = primitive.attributes.find(name);
      named != primitive.attributes.end() && named->second >= 0 &&
      static_cast<std::size_t>(named->second) < file.model.accessors.size()) {
    const tinygltf::Accessor& accessor = file.model.accessors[static_cast<std::size_t>(named->second)];
    component_type = accessor.componentType;
    normalized = accessor.normalized;
  }
  const int attribute_id = unique_id < 0 ? -1 : mesh.GetAttributeIdByUniqueId(static_cast<std::uint32_t>(unique_id));
  if (attribute_id < 0) return file.error(where + ": Draco stream has no attribute " + std::to_string(unique_id));
  draco::PointAttribute* const attribute = mesh.attribute(attribute_id);
  if (attribute->num_components() != kComponents)
    return file.error(where + ": Draco " + name + " has not " + std::to_string(kComponents) + " components");
  attribute->set_normalized(false);
  std::vector<std::array<double, kComponents>> values(mesh.num_points());
  for (std::uint32_t i = 0; i < mesh.num_points(); ++i) {
    const draco::AttributeValueIndex at = attribute->mapped_index(draco::PointIndex(i));
    if (at.value() >= attribute->size() || !attribute->ConvertValue<double, kComponents>(at, values[i].data()))
      return file.error(where + ": Draco point " + std::to_string(i) + " has no " + name);
    for (double& number : values[i]) number = dequantised(number, component_type, normalized);
  }
  return values;
}

}  // namespace

Result<GltfGeometry> read_draco_primitive(const GltfFile& file, const tinygltf::Primitive& primitive, int texcoord,
                                          const std::string& where) {
  const tinygltf::Value& extension = primitive.extensions.at(kDraco);
  if (!extension.IsObject() || !extension.Get("bufferView").IsInt() || !extension.Get("attributes").IsObject() ||
      !extension.Get("attributes").Get("POSITION").IsInt())
    return file.error(where + ": " + kDraco + " lacks its bufferView or its POSITION");
  ZC_ASSIGN(const std::span<const std::byte> bytes, file.view(extension.Get("bufferView").GetNumberAsInt()));
  const int unique_id = extension.Get("attributes").Get("POSITION").GetNumberAsInt();
  ZC_TRY(check_declared(bytes, file, where));

  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) {
    const std::string cause = one_line(decoded.status().error_msg_string());
    return file.error(where + ": damaged Draco stream" + (cause.empty() ? "" : ": " + cause));
  }
  const std::unique_ptr<draco::Mesh> mesh = std::move(decoded).value();
  GltfGeometry geometry;
  const std::uint32_t points = mesh->num_points();
  ZC_ASSIGN(const auto positions, read_attribute<3>(file, primitive, "POSITION", unique_id, *mesh, where));
  geometry.positions.reserve(points);
  for (const auto& p : positions) geometry.positions.emplace_back(p[0], p[1], p[2]);
  const std::string texcoord_name = "TEXCOORD_" + std::to_string(texcoord);
  if (const tinygltf::Value& id = extension.Get("attributes").Get(texcoord_name); texcoord >= 0 && id.IsInt()) {
    ZC_ASSIGN(const auto uvs, read_attribute<2>(file, primitive, texcoord_name, id.GetNumberAsInt(), *mesh, where));
    for (const auto& uv : uvs) geometry.texcoords.emplace_back(uv[0], uv[1]);
  }
  if (const tinygltf::Value& id = extension.Get("attributes").Get("COLOR_0"); id.IsInt()) {
    const int color_id = id.GetNumberAsInt();
    const draco::PointAttribute* const color =
        color_id < 0 ? nullptr : mesh->GetAttributeByUniqueId(static_cast<std::uint32_t>(color_id));
    const auto keep = [&](const auto& values) {
      for (const auto& rgb : values) geometry.colors.emplace_back(rgb[0], rgb[1], rgb[2]);
    };
    if (color != nullptr && color->num_components() == 4) {
      ZC_ASSIGN(const auto rgba, read_attribute<4>(file, primitive, "COLOR_0", color_id, *mesh, where));
      keep(rgba);
    } else {
      ZC_ASSIGN(const auto rgb, read_attribute<3>(file, primitive, "COLOR_0", color_id, *mesh, where));
      keep(rgb);
    }
  }
  geometry.triangles.reserve(mesh->num_faces());
  for (draco::FaceIndex f(0); f < mesh->num_faces(); ++f) {
    const draco::Mesh::Face& face = mesh->face(f);
    for (const draco::PointIndex& corner : face)
      if (corner.value() >= points)
        return file.error(where + ": vertex index " + std::to_string(corner.value()) + " out of range (" +
                          std::to_string(points) + " vertices) in the Draco stream");
    geometry.triangles.push_back({face[0].value(), face[1].value(), face[2].value()});
  }
  return geometry;
}

}  // namespace zc
