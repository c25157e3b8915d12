// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/gltf/gltf_geometry.h"

#include <algorithm>
#include <cstring>
#include <optional>

namespace zc {
namespace {

constexpr const char* kDraco = "KHR_draco_mesh_compression";

double component(const std::byte* at, int type) {
  const auto load = [at]<class T>(T value) {
    std::memcpy(&value, at, sizeof value);
    return static_cast<double>(value);
  };
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return load(std::int8_t{});
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return load(std::uint8_t{});
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return load(std::int16_t{});
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return load(std::uint16_t{});
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return load(std::uint32_t{});
    default:
      return load(float{});
  }
}

std::size_t component_bytes(int type) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return 4;
    default:
      return 0;
  }
}

// `count` elements of `components` numbers each, as doubles; values up to 2^32 and floats are exact.
Result<std::vector<double>> read_elements(const GltfFile& file, int view_index, std::size_t offset, int type,
                                          std::size_t components, std::size_t count, const std::string& where) {
  ZC_ASSIGN(const std::span<const std::byte> view, file.view(view_index));
  const std::size_t part = component_bytes(type);
  const std::size_t element = part * components;
  if (part == 0) return file.error(where + " has component type " + std::to_string(type));
  const std::size_t declared = file.model.bufferViews[static_cast<std::size_t>(view_index)].byteStride;
  const std::size_t stride = declared == 0 ? element : declared;
  // count - 1 strides and one element must fit; divided, so that nothing overflows.
  if (stride < element || offset > view.size() ||
      (count > 0 && (view.size() - offset < element || count - 1 > (view.size() - offset - element) / stride)))
    return file.error(where + " reaches past the " + std::to_string(view.size()) + " bytes of its bufferView");
  std::vector<double> values(count * components);
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t c = 0; c < components; ++c)
      values[i * components + c] = component(view.data() + offset + i * stride + c * part, type);
  return values;
}

Status apply_sparse(const GltfFile& file, const tinygltf::Accessor& accessor, std::size_t components,
                    const std::string& where, std::vector<double>& values) {
  const auto& sparse = accessor.sparse;
  if (sparse.count < 0 || sparse.indices.byteOffset < 0 || sparse.values.byteOffset < 0)
    return file.error(where + " has a negative number in its sparse part");
  const auto count = static_cast<std::size_t>(sparse.count);
  ZC_ASSIGN(const std::vector<double> indices,
            read_elements(file, sparse.indices.bufferView, static_cast<std::size_t>(sparse.indices.byteOffset),
                          sparse.indices.componentType, 1, count, where + " (sparse indices)"));
  ZC_ASSIGN(const std::vector<double> patches,
            read_elements(file, sparse.values.bufferView, static_cast<std::size_t>(sparse.values.byteOffset),
                          accessor.componentType, components, count, where + " (sparse values)"));
  for (std::size_t i = 0; i < count; ++i) {
    if (!(indices[i] >= 0) || indices[i] >= static_cast<double>(accessor.count))
      return file.error(where + " has a sparse index out of range");
    std::copy_n(patches.begin() + static_cast<std::ptrdiff_t>(i * components), components,
                values.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(indices[i]) * components));
  }
  return {};
}

// Triangles of a list, strip or fan over `count` corners.
std::vector<std::array<std::uint32_t, 3>> corners_of(int mode, std::uint32_t count) {
  std::vector<std::array<std::uint32_t, 3>> corners;
  if (count < 3) return corners;
  if (mode == TINYGLTF_MODE_TRIANGLES) {
    for (std::uint32_t i = 0; i + 2 < count; i += 3) corners.push_back({i, i + 1, i + 2});
  } else if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) {
    for (std::uint32_t i = 0; i + 2 < count; ++i)
      corners.push_back(i % 2 == 0 ? std::array{i, i + 1, i + 2} : std::array{i, i + 2, i + 1});
  } else {
    for (std::uint32_t i = 1; i + 1 < count; ++i) corners.push_back({i, i + 1, 0});
  }
  return corners;
}

}  // namespace

Result<std::vector<double>> read_accessor(const GltfFile& file, int index, int wanted_type, std::size_t components,
                                          const std::string& where, GltfBudget& budget) {
  if (index < 0 || static_cast<std::size_t>(index) >= file.model.accessors.size())
    return file.error(where + " names accessor " + std::to_string(index) + ", which does not exist");
  const tinygltf::Accessor& accessor = file.model.accessors[static_cast<std::size_t>(index)];
  const std::string place = where + ", accessor " + std::to_string(index);
  if (accessor.type != wanted_type) return file.error(place + " has the wrong type");
  ZC_TRY(budget.read(accessor.count, accessor.bufferView < 0, place));
  std::vector<double> values;
  if (accessor.bufferView >= 0) {
    ZC_ASSIGN(values, read_elements(file, accessor.bufferView, accessor.byteOffset, accessor.componentType, components,
                                    accessor.count, place));
  } else {
    if (!accessor.sparse.isSparse) return file.error(place + " has no bufferView");
    values.assign(accessor.count * components, 0.0);
  }
  if (accessor.sparse.isSparse) ZC_TRY(apply_sparse(file, accessor, components, place, values));
  for (double& value : values) value = dequantised(value, accessor.componentType, accessor.normalized);
  return values;
}

double dequantised(double stored, int component_type, bool normalized) {
  if (!normalized) return stored;
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return std::max(stored / 127.0, -1.0);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return stored / 255.0;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return std::max(stored / 32767.0, -1.0);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return stored / 65535.0;
    default:
      return stored;
  }
}

namespace {

// Many primitives may share one accessor of positions, each using a few.
void drop_unused(GltfGeometry& geometry) {
  if (geometry.positions.size() <= 3 * geometry.triangles.size()) return;
  constexpr std::uint32_t kUnused = UINT32_MAX;
  std::vector<std::uint32_t> place(geometry.positions.size(), kUnused);
  GltfGeometry used;
  for (auto& triangle : geometry.triangles)
    for (std::uint32_t& corner : triangle) {
      if (place[corner] == kUnused) {
        place[corner] = static_cast<std::uint32_t>(used.positions.size());
        used.positions.push_back(geometry.positions[corner]);
        if (!geometry.texcoords.empty()) used.texcoords.push_back(geometry.texcoords[corner]);
        if (!geometry.colors.empty()) used.colors.push_back(geometry.colors[corner]);
      }
      corner = place[corner];
    }
  geometry.positions = std::move(used.positions);
  geometry.texcoords = std::move(used.texcoords);
  geometry.colors = std::move(used.colors);
}

Result<GltfGeometry> read_plain_primitive(const GltfFile& file, const tinygltf::Primitive& primitive, int texcoord,
                                          const std::string& where, GltfBudget& budget) {
  GltfGeometry geometry;
  const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
  if (mode > TINYGLTF_MODE_TRIANGLE_FAN) return file.error(where + " has mode " + std::to_string(mode));
  const auto position = primitive.attributes.find("POSITION");
  if (mode < TINYGLTF_MODE_TRIANGLES || position == primitive.attributes.end()) return geometry;
  ZC_ASSIGN(const std::vector<double> values,
            read_accessor(file, position->second, TINYGLTF_TYPE_VEC3, 3, where + " POSITION", budget));
  const std::size_t count = values.size() / 3;
  geometry.positions.reserve(count);
  for (std::size_t i = 0; i < count; ++i)
    geometry.positions.emplace_back(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
  const std::string texcoord_name = "TEXCOORD_" + std::to_string(texcoord);
  if (const auto at = primitive.attributes.find(texcoord_name); texcoord >= 0 && at != primitive.attributes.end()) {
    ZC_ASSIGN(const std::vector<double> uv,
              read_accessor(file, at->second, TINYGLTF_TYPE_VEC2, 2, where + " " + texcoord_name, budget));
    if (uv.size() != 2 * count) return file.error(where + " has not as many texture coordinates as positions");
    for (std::size_t i = 0; i < count; ++i) geometry.texcoords.emplace_back(uv[2 * i], uv[2 * i + 1]);
  }

  if (const auto at = primitive.attributes.find("COLOR_0"); at != primitive.attributes.end()) {
    const bool alpha = at->second >= 0 && static_cast<std::size_t>(at->second) < file.model.accessors.size() &&
                       file.model.accessors[static_cast<std::size_t>(at->second)].type == TINYGLTF_TYPE_VEC4;
    const std::size_t parts = alpha ? 4 : 3;
    ZC_ASSIGN(const std::vector<double> rgb,
              read_accessor(file, at->second, alpha ? TINYGLTF_TYPE_VEC4 : TINYGLTF_TYPE_VEC3, parts,
                            where + " COLOR_0", budget));
    if (rgb.size() != parts * count) return file.error(where + " has not as many colours as positions");
    for (std::size_t i = 0; i < count; ++i)
      geometry.colors.emplace_back(rgb[parts * i], rgb[parts * i + 1], rgb[parts * i + 2]);
  }

  std::optional<std::vector<double>> indices;
  if (primitive.indices >= 0) {
    ZC_ASSIGN(indices, read_accessor(file, primitive.indices, TINYGLTF_TYPE_SCALAR, 1, where + " indices", budget));
    for (const double index : *indices)
      if (!(index >= 0) || index >= static_cast<double>(count))
        return file.error(where + ": vertex index " + std::to_string(static_cast<std::int64_t>(index)) +
                          " out of range (" + std::to_string(count) + " vertices)");
  }
  const std::size_t corner_count = indices ? indices->size() : count;
  if (corner_count > 0xFFFF'FFFFU) return file.error(where + " has more than 2^32 corners");
  geometry.triangles = corners_of(mode, static_cast<std::uint32_t>(corner_count));
  if (mode == TINYGLTF_MODE_TRIANGLES) geometry.loose_corners = static_cast<std::uint32_t>(corner_count % 3);
  if (indices)
    for (auto& triangle : geometry.triangles)
      for (std::uint32_t& corner : triangle) corner = static_cast<std::uint32_t>((*indices)[corner]);
  return geometry;
}

}  // namespace

Result<GltfGeometry> read_primitive(const GltfFile& file, const tinygltf::Primitive& primitive, int texcoord,
                                    const std::string& where, GltfBudget& budget) {
  ZC_ASSIGN(GltfGeometry geometry, primitive.extensions.contains(kDraco)
                                       ? read_draco_primitive(file, primitive, texcoord, where)
                                       : read_plain_primitive(file, primitive, texcoord, where, budget));
  drop_unused(geometry);
  ZC_TRY(budget.keep(geometry.positions.size() + geometry.triangles.size(), where));
  return geometry;
}

}  // namespace zc
