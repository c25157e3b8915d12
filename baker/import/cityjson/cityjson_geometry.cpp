// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/cityjson/cityjson_geometry.h"

#include <array>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "baker/import/shared/json_text.h"
#include "baker/import/shared/polygon.h"
#include "baker/import/shared/surface_material.h"

namespace zc {
namespace {

using nlohmann::json;

// How many arrays lie around each surface in `boundaries`; 0 for geometry without surfaces.
constexpr std::array<std::pair<std::string_view, int>, 7> kDepths = {{{"MultiPoint", 0},
                                                                      {"MultiLineString", 0},
                                                                      {"MultiSurface", 1},
                                                                      {"CompositeSurface", 1},
                                                                      {"Solid", 2},
                                                                      {"MultiSolid", 3},
                                                                      {"CompositeSolid", 3}}};

std::optional<int> depth_of(std::string_view type) {
  for (const auto& [name, depth] : kDepths)
    if (name == type) return depth;
  return std::nullopt;
}

// The values of a geometry for each of its surfaces; null where there are none. Nested like the boundaries.
struct Labels {
  const json* semantics = nullptr;
  const json* materials = nullptr;
  const json* textures = nullptr;
};

// The label of one child; null when the list is absent or ends early.
const json* child_label(const json* labels, std::size_t index) {
  if (labels == nullptr || !labels->is_array() || index >= labels->size()) return nullptr;
  const json& label = (*labels)[index];
  return label.is_null() ? nullptr : &label;
}

class GeometryReader {
 public:
  GeometryReader(const CityContext& context, const CityObjectRef& object, const glm::dmat4* placement, ObjectMesh& mesh)
      : context_(context), object_(object), placement_(placement), mesh_(mesh) {
    mirrored_ = placement != nullptr && glm::determinant(glm::dmat3(*placement)) < 0;
  }

  Status read(const json& geometry) {
    const json* type = find_member(geometry, "type");
    const std::string name = type != nullptr && type->is_string() ? type->get<std::string>() : "";
    const auto depth = depth_of(name);
    if (!depth) return fault("geometry of unknown type '" + one_line(name) + "'");
    if (*depth == 0) return {};
    drop_closures_ = name == "MultiSurface";
    const json* boundaries = find_member(geometry, "boundaries");
    if (boundaries == nullptr) return fault("geometry has no boundaries");
    Labels labels;
    if (const json* semantics = find_member(geometry, "semantics"); semantics != nullptr) {
      ZC_TRY(read_semantics(*semantics));
      labels.semantics = find_member(*semantics, "values");
    }
    ZC_ASSIGN(const json* material, theme(geometry, "material", context_.appearance.material_theme));
    if (material != nullptr) {
      labels.materials = find_member(*material, "values");
      if (const json* one = find_member(*material, "value"); one != nullptr) whole_material_ = one;
    }
    ZC_ASSIGN(const json* texture, theme(geometry, "texture", context_.appearance.texture_theme));
    if (texture != nullptr) labels.textures = find_member(*texture, "values");
    return walk(*boundaries, *depth, labels);
  }

 private:
  [[nodiscard]] Error fault(const std::string& message) const {
    return context_.source.object_error(object_.id, message);
  }

  // The default theme where the geometry has it, else the first by name.
  [[nodiscard]] Result<const json*> theme(const json& geometry, const char* key, const std::string& preferred) const {
    const json* themes = find_member(geometry, key);
    if (themes == nullptr) return nullptr;
    if (!themes->is_object()) return fault(std::string(key) + " is not an object");
    if (themes->empty()) return nullptr;
    const auto named = themes->find(preferred);
    const json& chosen = named != themes->end() ? *named : *themes->begin();
    if (!chosen.is_object()) return fault(std::string(key) + " theme is not an object");
    if (themes->size() > 1)
      context_.builder.note(std::string(key) + " themes besides the one used, left out", themes->size() - 1);
    return &chosen;
  }

  Status read_semantics(const json& semantics) {
    const json* surfaces = find_member(semantics, "surfaces");
    if (surfaces == nullptr) return {};
    if (!surfaces->is_array()) return fault("semantics surfaces is not an array");
    for (const json& surface : *surfaces) {
      const json* type = find_member(surface, "type");
      if (type == nullptr || !type->is_string()) return fault("a semantic surface has no type");
      semantics_.push_back(surface_of_semantics(type->get_ref<const std::string&>()));
    }
    return {};
  }

  Status walk(const json& node, int depth, const Labels& labels) {
    if (!node.is_array()) return fault("boundaries are not nested as the geometry type asks");
    if (depth == 0) return add_surface(node, labels);
    note_early_end(labels.semantics, node.size(),
                   "surfaces or shells behind the last semantic value, taken as unnamed");
    note_early_end(labels.materials, node.size(), "surfaces or shells behind the last material value, without it");
    note_early_end(labels.textures, node.size(), "surfaces or shells behind the last texture value, without it");
    for (std::size_t i = 0; i < node.size(); ++i)
      // A single number above the surfaces labels everything below it.
      ZC_TRY(walk(node[i], depth - 1,
                  {inherit(labels.semantics, i), inherit(labels.materials, i), child_label(labels.textures, i)}));
    return {};
  }

  void note_early_end(const json* labels, std::size_t wanted, const char* what) {
    if (labels != nullptr && labels->is_array() && labels->size() < wanted)
      context_.builder.note(what, wanted - labels->size());
  }

  static const json* inherit(const json* labels, std::size_t index) {
    return labels != nullptr && labels->is_number() ? labels : child_label(labels, index);
  }

  Status add_surface(const json& rings, const Labels& labels) {
    polygon_.clear();
    for (const json& ring : rings) {
      if (!ring.is_array()) return fault("a ring is not an array of vertex indices");
      for (const json& entry : ring) {
        const auto index = as_unsigned(entry);
        if (!index || *index >= context_.vertices.size())
          return fault("vertex index " + one_line(entry.dump(-1, ' ', false, json::error_handler_t::replace)) +
                       " out of range (" + std::to_string(context_.vertices.size()) + " vertices)");
        const glm::dvec3& vertex = context_.vertices[*index];
        polygon_.add_point(placement_ == nullptr ? vertex : glm::dvec3(*placement_ * glm::dvec4(vertex, 1)));
      }
      polygon_.end_ring();
    }
    const glm::dvec3 normal = newell_normal(polygon_) * (mirrored_ ? -1.0 : 1.0);
    const double length = glm::length(normal);
    ZC_ASSIGN(const Surface surface, surface_kind(labels.semantics, length > 0 ? normal.z / length : 0));
    if (surface == Surface::kClosure && drop_closures_) {
      context_.builder.note("closure surfaces of open geometry, dropped");
      return {};
    }
    cut_.clear();
    const auto [outcome, filled_holes] = triangulate_polygon(polygon_, cut_);
    if (const char* loss = loss_of(outcome)) context_.builder.note(loss);
    if (filled_holes > 0) context_.builder.note(kFilledHoles, filled_holes);
    if (cut_.empty()) return {};
    ZC_ASSIGN(const Paint paint, paint_of(labels));
    const std::uint16_t material =
        context_.builder.material(surface_material(surface, object_.type, object_.palette_key, paint));
    const std::size_t base = mesh_.positions.size();
    if (base + polygon_.points.size() > 0xFFFF'FFFFU) return fault("object has more than 2^32 corners");
    mesh_.positions.insert(mesh_.positions.end(), polygon_.points.begin(), polygon_.points.end());
    if (paint.texture) ZC_TRY(read_texcoords(labels.textures));
    for (const auto& [a, b, c] : cut_) {
      const auto at = [base](std::uint32_t corner) { return static_cast<std::uint32_t>(base + corner); };
      const std::array corners = mirrored_ ? std::array{a, c, b} : std::array{a, b, c};
      if (paint.texture && !texcoords_.empty())
        mesh_.texcoords.push_back({static_cast<std::uint32_t>(mesh_.triangles.size()),
                                   {texcoords_[corners[0]], texcoords_[corners[1]], texcoords_[corners[2]]}});
      mesh_.triangles.push_back({at(corners[0]), at(corners[1]), at(corners[2])});
      mesh_.materials.push_back(material);
    }
    return {};
  }

  [[nodiscard]] Result<Surface> surface_kind(const json* label, double up) const {
    if (label != nullptr) {
      const auto index = as_unsigned(*label);
      if (!index || *index >= semantics_.size())
        return fault("semantic value " + one_line(label->dump()) + " out of range (" +
                     std::to_string(semantics_.size()) + " surfaces)");
      if (semantics_[*index]) return *semantics_[*index];
    }
    return surface_of_object(object_.type, up);
  }

  [[nodiscard]] Result<Paint> paint_of(const Labels& labels) const {
    const CityAppearance& appearance = context_.appearance;
    Paint paint;
    const json* material = labels.materials != nullptr ? labels.materials : whole_material_;
    if (material != nullptr) {
      const auto index = as_unsigned(*material);
      if (!index || *index >= appearance.materials.size())
        return fault("material index " + one_line(material->dump()) + " out of range (" +
                     std::to_string(appearance.materials.size()) + " materials)");
      const CityMaterial& chosen = appearance.materials[*index];
      paint = {chosen.color, {}, chosen.transparent, chosen.name};
    }
    // The outer ring's list: texture index, then texture coordinates.
    const json* ring = child_label(labels.textures, 0);
    const json* texture = child_label(ring, 0);
    if (texture != nullptr) {
      const auto index = as_unsigned(*texture);
      if (!index || *index >= appearance.textures.size())
        return fault("texture index " + one_line(texture->dump()) + " out of range (" +
                     std::to_string(appearance.textures.size()) + " textures)");
      const auto& [image, wrap] = appearance.textures[*index];
      if (const auto loaded = context_.images.of_file(context_.source.image_file(image), image, context_.source.files))
        paint = {loaded->mean, SurfaceTexture{loaded->index, wrap, wrap}, paint.transparent, image};
    }
    return paint;
  }

  // One for every point of the polygon; none where a ring has too few. `rings`: a list for each, of a texture and then
  // the numbers of its texture coordinates.
  Status read_texcoords(const json* rings) {
    texcoords_.clear();
    std::uint32_t begin = 0;
    for (std::size_t r = 0; r < polygon_.ring_ends.size(); ++r) {
      const json* ring = child_label(rings, r);
      const std::uint32_t end = polygon_.ring_ends[r];
      if (begin < end && (ring == nullptr || !ring->is_array() || ring->size() < 1 + std::size_t{end - begin})) {
        context_.builder.note("textured surfaces without texture coordinates for every corner, mean colour used");
        texcoords_.clear();
        return {};
      }
      for (std::uint32_t i = begin; i < end; ++i) {
        const json& entry = (*ring)[1 + std::size_t{i - begin}];
        const auto index = as_unsigned(entry);
        if (!index || *index >= context_.appearance.texcoords.size())
          return fault("texture coordinate index " +
                       one_line(entry.dump(-1, ' ', false, json::error_handler_t::replace)) + " out of range (" +
                       std::to_string(context_.appearance.texcoords.size()) + " texture coordinates)");
        const glm::vec2& uv = context_.appearance.texcoords[*index];
        texcoords_.emplace_back(uv.x, 1 - uv.y);
      }
      begin = end;
    }
    for (const auto& [from, to, part] : polygon_.crossings)
      texcoords_.push_back(glm::mix(texcoords_[from], texcoords_[to], static_cast<float>(part)));
    return {};
  }

  const CityContext& context_;
  const CityObjectRef& object_;
  const glm::dmat4* placement_;
  ObjectMesh& mesh_;
  bool mirrored_ = false;
  bool drop_closures_ = false;
  std::vector<std::optional<Surface>> semantics_;
  const json* whole_material_ = nullptr;
  Polygon polygon_;                                // reused
  std::vector<glm::vec2> texcoords_;               // reused; of the polygon's points
  std::vector<std::array<std::uint32_t, 3>> cut_;  // reused
};

}  // namespace

std::optional<bool> has_surfaces(const std::string& geometry_type) {
  const auto depth = depth_of(geometry_type);
  if (!depth) return std::nullopt;
  return *depth > 0;
}

Status add_city_geometry(const json& geometry, const CityContext& context, const CityObjectRef& object,
                         const glm::dmat4* placement, ObjectMesh& mesh) {
  return GeometryReader(context, object, placement, mesh).read(geometry);
}

}  // namespace zc
