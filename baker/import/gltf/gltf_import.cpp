// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/gltf/gltf_import.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <glm/common.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <optional>
#include <string_view>

#include "baker/import/gltf/gltf_file.h"
#include "baker/import/gltf/gltf_geometry.h"
#include "baker/import/shared/uri.h"
#include "base/text.h"

namespace zc {
namespace {

// Turns the axis to z. Columns.
glm::dmat4 upright(UpAxis up) {
  switch (up) {
    case UpAxis::kX:
      return {{0, 0, 1, 0}, {0, 1, 0, 0}, {-1, 0, 0, 0}, {0, 0, 0, 1}};
    case UpAxis::kY:
      return {{1, 0, 0, 0}, {0, 0, 1, 0}, {0, -1, 0, 0}, {0, 0, 0, 1}};
    case UpAxis::kZ:
      break;
  }
  return glm::dmat4(1);
}

ObjectKind kind_of(const std::string& name) {
  constexpr std::array<std::string_view, 7> kGroundNames = {"ground",   "road",         "terrain", "street",
                                                            "sidewalk", "plaza_ground", "water"};
  const std::string lower_name = lower(name);
  const bool ground = std::any_of(kGroundNames.begin(), kGroundNames.end(),
                                  [&](std::string_view prefix) { return lower_name.starts_with(prefix); });
  return ground ? ObjectKind::kGround : ObjectKind::kObject;
}

Result<glm::dmat4> local_transform(const GltfFile& file, const tinygltf::Node& node, std::size_t index) {
  const auto fits = [](const std::vector<double>& values, std::size_t size) {
    return values.empty() || values.size() == size;
  };
  if (!fits(node.matrix, 16) || !fits(node.translation, 3) || !fits(node.rotation, 4) || !fits(node.scale, 3))
    return file.error("node " + std::to_string(index) + " has a transform of the wrong length");
  glm::dmat4 matrix(1);
  if (!node.matrix.empty()) {
    for (int column = 0; column < 4; ++column)
      for (int row = 0; row < 4; ++row)
        matrix[column][row] = node.matrix[4 * static_cast<std::size_t>(column) + static_cast<std::size_t>(row)];
    return matrix;
  }
  if (!node.rotation.empty()) {
    const glm::dquat turn(node.rotation[3], node.rotation[0], node.rotation[1], node.rotation[2]);
    if (glm::length(turn) > 0) matrix = glm::mat4_cast(glm::normalize(turn));
  }
  if (!node.scale.empty())
    for (int axis = 0; axis < 3; ++axis) matrix[axis] *= node.scale[static_cast<std::size_t>(axis)];
  if (!node.translation.empty())
    matrix[3] = glm::dvec4(node.translation[0], node.translation[1], node.translation[2], 1);
  return matrix;
}

class GltfImport {
 public:
  GltfImport(const GltfFile& file, const GltfPlace& place, TextureImages& images, SceneBuilder& builder)
      : file_(file),
        place_(place),
        images_(images),
        builder_(builder),
        budget_(file.path, file.stored_bytes),
        meshes_(file.model.meshes.size()) {}

  Status run() {
    if (file_.morph_targets > 0)
      builder_.note("glTF primitives with morph targets, shown without them", file_.morph_targets);
    ZC_ASSIGN(const std::vector<int> roots, root_nodes());
    struct Visit {
      int node;
      glm::dmat4 parent;
    };
    std::vector<Visit> stack;
    const glm::dmat4 placement = glm::translate(place_.to_world, file_.center) * upright(place_.up);
    for (auto root = roots.rbegin(); root != roots.rend(); ++root) stack.push_back({*root, placement});
    std::vector<bool> seen(file_.model.nodes.size());
    while (!stack.empty()) {
      const Visit visit = stack.back();
      stack.pop_back();
      const auto index = static_cast<std::size_t>(visit.node);
      if (visit.node < 0 || index >= seen.size())
        return file_.error("node " + std::to_string(visit.node) + " does not exist");
      if (seen[index]) return file_.error("node " + std::to_string(visit.node) + " has two parents or is its own");
      seen[index] = true;
      const tinygltf::Node& node = file_.model.nodes[index];
      ZC_ASSIGN(const glm::dmat4 local, local_transform(file_, node, index));
      const glm::dmat4 world = visit.parent * local;
      if (node.mesh >= 0) ZC_TRY(add_node(node, index, world));
      for (auto child = node.children.rbegin(); child != node.children.rend(); ++child)
        stack.push_back({*child, world});
    }
    return {};
  }

 private:
  struct Part {
    GltfGeometry geometry;
    std::vector<std::uint16_t> materials;  // per triangle
  };

  // Of the default scene, else the first one, else every node that is nobody's child.
  [[nodiscard]] Result<std::vector<int>> root_nodes() const {
    const tinygltf::Model& model = file_.model;
    if (!model.scenes.empty()) {
      const auto index = static_cast<std::size_t>(std::max(model.defaultScene, 0));
      if (index >= model.scenes.size())
        return file_.error("scene " + std::to_string(model.defaultScene) + " does not exist");
      return model.scenes[index].nodes;
    }
    std::vector<bool> is_child(model.nodes.size());
    for (const tinygltf::Node& node : model.nodes)
      for (const int child : node.children)
        if (child >= 0 && static_cast<std::size_t>(child) < is_child.size())
          is_child[static_cast<std::size_t>(child)] = true;
    std::vector<int> roots;
    for (std::size_t i = 0; i < is_child.size(); ++i)
      if (!is_child[i]) roots.push_back(static_cast<int>(i));
    return roots;
  }

  Status add_node(const tinygltf::Node& node, std::size_t index, const glm::dmat4& world) {
    const auto mesh_index = static_cast<std::size_t>(node.mesh);
    if (mesh_index >= meshes_.size())
      return file_.error("node " + std::to_string(index) + " names mesh " + std::to_string(node.mesh) +
                         ", which does not exist");
    const std::string id = node.name.empty() ? "node_" + std::to_string(index) : node.name;
    builder_.enter_object(id);
    if (!meshes_[mesh_index]) ZC_TRY(load_mesh(mesh_index));
    if (node.skin >= 0) builder_.note("skinned glTF meshes, shown as they were modelled");
    const auto instancing = node.extensions.find("EXT_mesh_gpu_instancing");
    std::uint64_t triangles = 0;
    for (const Part& part : *meshes_[mesh_index]) triangles += part.geometry.triangles.size();
    const std::string where = "node " + std::to_string(index);
    if (instancing == node.extensions.end()) {
      ZC_TRY(budget_.draw(triangles, 1, where));
      return add_object(id, node.mesh, world);
    }
    ZC_ASSIGN(const std::vector<glm::dmat4> places, instances(instancing->second, index));
    ZC_TRY(budget_.draw(triangles, places.size(), where));
    for (std::size_t i = 0; i < places.size(); ++i)
      ZC_TRY(add_object(id + "_" + std::to_string(i), node.mesh, world * places[i]));
    return {};
  }

  // EXT_mesh_gpu_instancing: where each instance stands in the node's frame.
  [[nodiscard]] Result<std::vector<glm::dmat4>> instances(const tinygltf::Value& extension, std::size_t node) {
    const std::string where = "node " + std::to_string(node) + " EXT_mesh_gpu_instancing";
    const tinygltf::Value& attributes = extension.Get("attributes");
    std::optional<std::size_t> count;
    const auto read = [&](const char* name, int type, std::size_t components) -> Result<std::vector<double>> {
      const tinygltf::Value& accessor = attributes.Get(name);
      if (!accessor.IsInt()) return std::vector<double>{};
      ZC_ASSIGN(std::vector<double> values,
                read_accessor(file_, accessor.GetNumberAsInt(), type, components, where + " " + name, budget_));
      if (count && *count != values.size() / components) return file_.error(where + " has lists of different lengths");
      count = values.size() / components;
      return values;
    };
    ZC_ASSIGN(const std::vector<double> moved, read("TRANSLATION", TINYGLTF_TYPE_VEC3, 3));
    ZC_ASSIGN(const std::vector<double> turned, read("ROTATION", TINYGLTF_TYPE_VEC4, 4));
    ZC_ASSIGN(const std::vector<double> scaled, read("SCALE", TINYGLTF_TYPE_VEC3, 3));
    std::vector<glm::dmat4> places(count.value_or(0), glm::dmat4(1));
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (!turned.empty()) {
        const glm::dquat turn(turned[4 * i + 3], turned[4 * i], turned[4 * i + 1], turned[4 * i + 2]);
        if (glm::length(turn) > 0) places[i] = glm::mat4_cast(glm::normalize(turn));
      }
      for (int axis = 0; axis < 3; ++axis) {
        const auto at = 3 * i + static_cast<std::size_t>(axis);
        if (!scaled.empty()) places[i][axis] *= scaled[at];
        if (!moved.empty()) places[i][3][axis] = moved[at];
      }
    }
    return places;
  }

  Status add_object(const std::string& id, int mesh, const glm::dmat4& world) {
    const auto mesh_index = static_cast<std::size_t>(mesh);
    ObjectMesh object;
    object.id = id;
    object.kind = kind_of(id);
    const bool mirrored = glm::determinant(glm::dmat3(world)) < 0;
    for (const Part& part : *meshes_[mesh_index]) {
      const std::size_t base = object.positions.size();
      if (base + part.geometry.positions.size() > 0xFFFF'FFFFU)
        return Error{ErrorCode::kUnsupported, "mesh " + std::to_string(mesh) + " has more than 2^32 vertices",
                     file_.path};
      for (const glm::dvec3& p : part.geometry.positions) object.positions.emplace_back(world * glm::dvec4(p, 1));
      const auto& uv = part.geometry.texcoords;
      object.materials.insert(object.materials.end(), part.materials.begin(), part.materials.end());
      for (const auto& [a, b, c] : part.geometry.triangles) {
        const auto at = [base](std::uint32_t corner) { return static_cast<std::uint32_t>(base + corner); };
        const std::array corners = mirrored ? std::array{a, c, b} : std::array{a, b, c};
        if (!uv.empty())
          object.texcoords.push_back(
              {static_cast<std::uint32_t>(object.triangles.size()), {uv[corners[0]], uv[corners[1]], uv[corners[2]]}});
        object.triangles.push_back({at(corners[0]), at(corners[1]), at(corners[2])});
      }
    }
    return builder_.add(object);
  }

  Status load_mesh(std::size_t mesh_index) {
    const tinygltf::Mesh& mesh = file_.model.meshes[mesh_index];
    std::vector<Part> parts;
    for (std::size_t i = 0; i < mesh.primitives.size(); ++i) {
      const std::string where = "mesh " + std::to_string(mesh_index) + " primitive " + std::to_string(i);
      Part part;
      ZC_ASSIGN(const Appearance appearance, appearance_of(mesh.primitives[i].material, where));
      ZC_ASSIGN(part.geometry, read_primitive(file_, mesh.primitives[i], appearance.texcoord, where, budget_));
      if (part.geometry.loose_corners > 0)
        builder_.note("corners behind the last whole triangle of a list, left out", part.geometry.loose_corners);
      if (part.geometry.triangles.empty()) {
        builder_.note("glTF primitives without triangles (points, lines), left out");
        continue;
      }
      part.materials = materials_of(part.geometry, appearance.material);
      for (glm::vec2& uv : part.geometry.texcoords) uv = appearance.uv_transform * glm::vec3(uv, 1);
      keep_opaque(mesh.primitives[i].material, appearance.material, part);
      parts.push_back(std::move(part));
    }
    meshes_[mesh_index] = std::move(parts);
    return {};
  }

  // A triangle of one colour keeps it; of several it has their mean, roughly, so that gradients are not a material
  // each.
  std::vector<std::uint16_t> materials_of(const GltfGeometry& geometry, const Material& plain) {
    if (geometry.colors.empty() || plain.texture) {
      if (!geometry.colors.empty())
        builder_.note("glTF primitives with vertex colours over a texture, colours left out");
      return std::vector<std::uint16_t>(geometry.triangles.size(), builder_.material(plain));
    }
    std::vector<std::uint16_t> materials;
    for (const auto& [a, b, c] : geometry.triangles) {
      const auto& colors = geometry.colors;
      constexpr float kSteps = 31;
      glm::vec3 color = colors[a];
      if (colors[b] != color || colors[c] != color)
        color = glm::round((color + colors[b] + colors[c]) * (kSteps / 3)) / kSteps;
      if (!(std::isfinite(color.x) && std::isfinite(color.y) && std::isfinite(color.z)))
        builder_.note("triangles with vertex colours that are not finite, taken as 0 or 1");
      Material material = plain;
      for (int i = 0; i < 3; ++i) material.base_color[i] *= std::min(1.0F, std::max(0.0F, color[i]));  // no number: 0
      materials.push_back(builder_.material(material));
    }
    return materials;
  }

  // alphaMode: a page stores a surface or it does not, so what is transparent is cut off. Panes, of which no part is
  // opaque, stay: they reflect.
  void keep_opaque(int index, const Material& material, Part& part) {
    if (index < 0) return;
    const tinygltf::Material& source = file_.model.materials[static_cast<std::size_t>(index)];
    const bool is_mask = source.alphaMode == "MASK";
    if (!is_mask && source.alphaMode != "BLEND") return;
    const std::vector<double>& base = source.pbrMetallicRoughness.baseColorFactor;
    const double factor = base.size() < 4 ? 1.0 : std::clamp(base[3], 0.0, 1.0);
    const double cutoff = is_mask ? source.alphaCutoff : 0.5;
    const AlphaMask* mask = material.texture ? images_.mask_of(material.texture->image) : nullptr;
    const double share = mask != nullptr && factor > 0 ? mask->share_at_least(static_cast<float>(cutoff / factor))
                                                       : (factor >= cutoff ? 1.0 : 0.0);
    if (share == 1) return;
    constexpr double kPaneShare = 0.01;
    if (!is_mask && share < kPaneShare) {
      builder_.note("transparent glTF surfaces, kept as panes that are opaque", part.geometry.triangles.size());
      return;
    }
    if (mask == nullptr || part.geometry.texcoords.empty()) {
      if (share > 0) return;
      builder_.remark("glTF triangles that their alpha leaves nothing of, left out", part.geometry.triangles.size());
      part.geometry.triangles.clear();
      part.materials.clear();
      return;
    }
    builder_.remark("glTF triangles with transparent parts, which were cut off", part.geometry.triangles.size());
    cut_by_mask(*mask, *material.texture, static_cast<float>(cutoff / factor), part);
  }

  static void cut_by_mask(const AlphaMask& mask, const SurfaceTexture& texture, float cutoff, Part& part) {
    constexpr std::size_t kPiecesPerTriangle = 256;
    constexpr std::size_t kPiecesLeast = 1U << 13U;  // a fence may be two triangles
    constexpr std::size_t kPiecesMost = 1U << 17U;
    GltfGeometry& geometry = part.geometry;
    std::vector<AlphaMask::Triangle> triangles;
    triangles.reserve(geometry.triangles.size());
    for (const auto& [a, b, c] : geometry.triangles)
      triangles.push_back({{geometry.texcoords[a], geometry.texcoords[b], geometry.texcoords[c]}});
    const std::size_t most =
        std::max(triangles.size(), std::clamp(kPiecesPerTriangle * triangles.size(), kPiecesLeast, kPiecesMost));
    const AlphaMask::Cut cut = mask.cut(triangles, texture.wrap_u, texture.wrap_v, cutoff, most);
    if (cut.is_whole) return;
    GltfGeometry pieces;
    std::vector<std::uint16_t> materials;
    for (std::size_t i = 0; i < cut.pieces.size(); ++i) {
      const auto& corners = geometry.triangles[cut.of[i]];
      const auto first = static_cast<std::uint32_t>(pieces.positions.size());
      for (const glm::vec3& shares : cut.pieces[i]) {
        glm::dvec3 position(0);
        glm::vec2 uv(0);
        for (std::size_t c = 0; c < 3; ++c) {
          const float share = shares[static_cast<int>(c)];
          position += static_cast<double>(share) * geometry.positions[corners[c]];
          uv += share * geometry.texcoords[corners[c]];
        }
        pieces.positions.push_back(position);
        pieces.texcoords.push_back(uv);
      }
      pieces.triangles.push_back({first, first + 1, first + 2});
      materials.push_back(part.materials[cut.of[i]]);
    }
    geometry = std::move(pieces);
    part.materials = std::move(materials);
  }

  struct Appearance {
    Material material;
    int texcoord = -1;  // which of the primitive's sets; negative: none is needed
    glm::mat3x2 uv_transform{1, 0, 0, 1, 0, 0};
  };

  Result<Appearance> appearance_of(int index, const std::string& where) {
    Appearance appearance;
    appearance.material.name = "default";
    if (index < 0) return appearance;
    if (static_cast<std::size_t>(index) >= file_.model.materials.size())
      return file_.error(where + " names material " + std::to_string(index) + ", which does not exist");
    const tinygltf::Material& source = file_.model.materials[static_cast<std::size_t>(index)];
    const tinygltf::PbrMetallicRoughness& pbr = source.pbrMetallicRoughness;
    bool is_clamped = false;
    const auto unit = [&](double value) {
      const double within = value > 0 ? std::min(value, 1.0) : 0.0;  // no number: 0
      is_clamped |= within != value;
      return static_cast<float>(within);
    };
    Material& result = appearance.material;
    result.name = source.name.empty() ? "unnamed" : source.name;  // equal appearances of many files are one material
    result.base_color = glm::vec3(1);
    for (std::size_t c = 0; c < 3 && c < pbr.baseColorFactor.size(); ++c)
      result.base_color[static_cast<int>(c)] = unit(pbr.baseColorFactor[c]);
    result.roughness = unit(pbr.roughnessFactor);
    result.metallic = unit(pbr.metallicFactor);
    if (is_clamped) builder_.note("glTF materials with factors that are not within 0 and 1, clamped");
    const auto image = pbr.baseColorTexture.index >= 0 ? load_image(pbr.baseColorTexture.index) : std::nullopt;
    if (!image) return appearance;
    result.texture = SurfaceTexture{.image = image->index, .factor = result.base_color};
    result.base_color *= image->mean;
    const int sampler = file_.model.textures[static_cast<std::size_t>(pbr.baseColorTexture.index)].sampler;
    if (sampler >= 0 && static_cast<std::size_t>(sampler) < file_.model.samplers.size()) {
      result.texture->wrap_u = wrap_of(file_.model.samplers[static_cast<std::size_t>(sampler)].wrapS);
      result.texture->wrap_v = wrap_of(file_.model.samplers[static_cast<std::size_t>(sampler)].wrapT);
    }
    appearance.texcoord = pbr.baseColorTexture.texCoord;
    read_texture_transform(pbr.baseColorTexture.extensions, appearance);
    return appearance;
  }

  static TextureWrap wrap_of(int mode) {
    if (mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return TextureWrap::kClamp;
    return mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? TextureWrap::kMirror : TextureWrap::kRepeat;
  }

  // KHR_texture_transform: scaled, then turned, then moved.
  static void read_texture_transform(const tinygltf::ExtensionMap& extensions, Appearance& appearance) {
    const auto found = extensions.find("KHR_texture_transform");
    if (found == extensions.end() || !found->second.IsObject()) return;
    const tinygltf::Value& transform = found->second;
    const auto pair = [&](const char* key, glm::vec2 fallback) {
      const tinygltf::Value& value = transform.Get(key);
      if (!value.IsArray() || value.ArrayLen() != 2 || !value.Get(0).IsNumber() || !value.Get(1).IsNumber())
        return fallback;
      return glm::vec2(value.Get(0).GetNumberAsDouble(), value.Get(1).GetNumberAsDouble());
    };
    const glm::vec2 scale = pair("scale", glm::vec2(1));
    const glm::vec2 offset = pair("offset", glm::vec2(0));
    const tinygltf::Value& rotation = transform.Get("rotation");
    const auto angle = rotation.IsNumber() ? static_cast<float>(rotation.GetNumberAsDouble()) : 0.0F;
    const float c = std::cos(angle);
    const float s = std::sin(angle);
    appearance.uv_transform = {scale.x * c, -scale.x * s, scale.y * s, scale.y * c, offset.x, offset.y};
    if (const tinygltf::Value& set = transform.Get("texCoord"); set.IsInt()) appearance.texcoord = set.GetNumberAsInt();
  }

  // The plain image where there is one, else EXT_texture_webp's, else KHR_texture_basisu's, which will be named as not
  // read.
  static int source_of(const tinygltf::Texture& texture) {
    if (texture.source >= 0) return texture.source;
    for (const char* name : {"EXT_texture_webp", "KHR_texture_basisu"}) {
      const auto found = texture.extensions.find(name);
      if (found == texture.extensions.end() || !found->second.IsObject()) continue;
      const tinygltf::Value& source = found->second.Get("source");
      if (source.IsInt() && source.GetNumberAsInt() >= 0) return source.GetNumberAsInt();
    }
    return -1;
  }

  std::optional<LoadedImage> load_image(int texture) {
    const tinygltf::Model& model = file_.model;
    const int source = static_cast<std::size_t>(texture) < model.textures.size()
                           ? source_of(model.textures[static_cast<std::size_t>(texture)])
                           : -1;
    if (source < 0 || static_cast<std::size_t>(source) >= file_.images.size()) {
      builder_.note("missing texture sources, plain colours used");
      return std::nullopt;
    }
    const GltfImage& image = file_.images[static_cast<std::size_t>(source)];
    const std::string key =
        file_.path + " byte " + std::to_string(place_.byte_offset) + " image " + std::to_string(source);
    if (!image.uri.empty())
      return images_.of_file(file_of_uri(image.uri, file_.path, place_.root), image.uri, *place_.files);
    if (image.buffer_view < 0) return images_.of_bytes(key, image.embedded);
    const auto bytes = file_.view(image.buffer_view);
    return images_.of_bytes(key, bytes.ok() ? *bytes : std::span<const std::byte>{});
  }

  const GltfFile& file_;
  const GltfPlace& place_;
  TextureImages& images_;
  SceneBuilder& builder_;
  GltfBudget budget_;
  std::vector<std::optional<std::vector<Part>>> meshes_;  // decoded once, shared by the nodes that draw them
};

}  // namespace

Status import_gltf(std::vector<std::byte> bytes, const std::string& path, const GltfPlace& place, TextureImages& images,
                   SceneBuilder& builder) {
  Result<GltfFile> file = read_gltf(std::move(bytes), path, place.root, *place.files);
  if (!file) {
    Error error = std::move(file).error();
    if (error.path == path && error.byte_offset >= 0) error.byte_offset += place.byte_offset;
    return error;
  }
  return GltfImport(*file, place, images, builder).run();
}

}  // namespace zc
