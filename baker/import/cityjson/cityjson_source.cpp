// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/cityjson/cityjson_source.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "baker/import/shared/json_text.h"
#include "baker/import/shared/uri.h"

namespace zc {
namespace {

using nlohmann::json;

// More transparent than this is glass.
constexpr double kTransparent = 0.3;

bool read_triple(const json& value, glm::dvec3& out) {
  if (!value.is_array() || value.size() != 3) return false;
  for (int axis = 0; axis < 3; ++axis) {
    const json& number = value[static_cast<std::size_t>(axis)];
    if (!number.is_number()) return false;
    out[axis] = number.get<double>();
  }
  return true;
}

Result<std::string> text_member(const json& object, const char* key, const std::string& where,
                                const CitySource& source) {
  const json* member = find_member(object, key);
  if (member == nullptr) return std::string();
  if (!member->is_string()) return source.error(where + " has a " + key + " that is not text");
  return member->get<std::string>();
}

}  // namespace

Result<std::filesystem::path> CitySource::image_file(const std::string& name) const {
  return file_of_name(name, model, folder_of(model));
}

Error CitySource::error(std::string message) const {
  return {ErrorCode::kFormat, std::move(message), path, base_offset};
}

Error CitySource::object_error(const std::string& id, const std::string& message) const {
  const std::size_t at = text.find(json(id).dump(-1, ' ', false, json::error_handler_t::replace));
  const std::int64_t place = at == std::string_view::npos ? 0 : static_cast<std::int64_t>(at);
  return {ErrorCode::kFormat, "object '" + one_line(id) + "': " + message, path, base_offset + place};
}

Result<CityTransform> read_city_transform(const json& document, const CitySource& source) {
  CityTransform result;
  const json* transform = find_member(document, "transform");
  if (transform == nullptr) return result;
  const json* scale = find_member(*transform, "scale");
  const json* translate = find_member(*transform, "translate");
  if (scale == nullptr || translate == nullptr || !read_triple(*scale, result.scale) ||
      !read_triple(*translate, result.translate))
    return source.error("transform lacks scale or translate of three numbers");
  return result;
}

Result<std::vector<glm::dvec3>> read_city_vertices(const json& list, const CityTransform& transform,
                                                   const CitySource& source) {
  if (!list.is_array()) return source.error("vertices is not an array");
  std::vector<glm::dvec3> vertices;
  vertices.reserve(list.size());
  for (const json& entry : list) {
    glm::dvec3 vertex;
    if (!read_triple(entry, vertex))
      return source.error("vertex " + std::to_string(vertices.size()) + " is not three numbers");
    vertex = vertex * transform.scale + transform.translate;
    if (!std::isfinite(vertex.x) || !std::isfinite(vertex.y) || !std::isfinite(vertex.z))
      return source.error("vertex " + std::to_string(vertices.size()) + " is not finite");
    vertices.push_back(vertex);
  }
  return vertices;
}

Result<CityAppearance> read_city_appearance(const json& document, const CitySource& source) {
  CityAppearance result;
  const json* appearance = find_member(document, "appearance");
  if (appearance == nullptr) return result;
  if (!appearance->is_object()) return source.error("appearance is not an object");
  ZC_ASSIGN(result.texture_theme, text_member(*appearance, "default-theme-texture", "appearance", source));
  ZC_ASSIGN(result.material_theme, text_member(*appearance, "default-theme-material", "appearance", source));
  if (const json* textures = find_member(*appearance, "textures"); textures != nullptr) {
    if (!textures->is_array()) return source.error("appearance textures is not an array");
    for (const json& texture : *textures) {
      const std::string where = "texture " + std::to_string(result.textures.size());
      if (!texture.is_object()) return source.error(where + " is not an object");
      CityTexture entry;
      ZC_ASSIGN(entry.image, text_member(texture, "image", where, source));
      ZC_ASSIGN(const std::string wrap, text_member(texture, "wrapMode", where, source));
      if (wrap == "mirror") entry.wrap = TextureWrap::kMirror;
      if (wrap == "none" || wrap == "clamp" || wrap == "border") entry.wrap = TextureWrap::kClamp;
      result.textures.push_back(std::move(entry));
    }
  }
  if (const json* materials = find_member(*appearance, "materials"); materials != nullptr) {
    if (!materials->is_array()) return source.error("appearance materials is not an array");
    for (const json& material : *materials) {
      const std::string where = "material " + std::to_string(result.materials.size());
      if (!material.is_object()) return source.error(where + " is not an object");
      CityMaterial entry;
      ZC_ASSIGN(entry.name, text_member(material, "name", where, source));
      if (const json* diffuse = find_member(material, "diffuseColor"); diffuse != nullptr) {
        glm::dvec3 color;
        if (!read_triple(*diffuse, color)) return source.error(where + " has a diffuseColor that is not three numbers");
        for (int c = 0; c < 3; ++c) entry.color[c] = srgb_to_linear(static_cast<float>(std::clamp(color[c], 0.0, 1.0)));
      }
      if (const json* transparency = find_member(material, "transparency"); transparency != nullptr) {
        if (!transparency->is_number()) return source.error(where + " has a transparency that is not a number");
        entry.transparent = transparency->get<double>() > kTransparent;
      }
      result.materials.push_back(std::move(entry));
    }
  }
  if (const json* list = find_member(*appearance, "vertices-texture"); list != nullptr) {
    if (!list->is_array()) return source.error("vertices-texture is not an array");
    for (const json& entry : *list) {
      const auto numbers = as_numbers(entry, 2);
      if (!numbers)
        return source.error("texture coordinate " + std::to_string(result.texcoords.size()) + " is not two numbers");
      result.texcoords.emplace_back((*numbers)[0], (*numbers)[1]);
    }
  }
  return result;
}

}  // namespace zc
