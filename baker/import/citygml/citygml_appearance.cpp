// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/citygml/citygml_appearance.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "baker/import/citygml/gml_xml.h"

namespace zc {
namespace {

// More transparent than this is glass.
constexpr double kTransparent = 0.3;

// "#id" without its sign.
std::string reference(std::string_view text) {
  if (text.starts_with('#')) text.remove_prefix(1);
  return std::string(text);
}

template <class Map>
const typename Map::mapped_type* find(const Map& map, std::string_view key) {
  const auto at = map.find(key);
  return at != map.end() ? &at->second : nullptr;
}

}  // namespace

Result<GmlAppearance> GmlAppearance::read(const pugi::xml_node& model, const std::string& path, SceneBuilder& builder) {
  GmlAppearance out;
  std::optional<std::string> theme;
  Status status;
  // They lie in the model and in its features, at any depth.
  walk_gml(model, [&](const pugi::xml_node& node) {
    if (!status.ok()) return false;
    if (local_name(node) != "Appearance") return true;
    const std::string own(gml_text(gml_child(node, "theme")));
    if (!theme) theme = own;
    if (*theme == own)
      status = out.add(node, path, builder);
    else
      builder.note("appearances of further themes, left out");
    return false;
  });
  ZC_TRY(std::move(status));
  return out;
}

Status GmlAppearance::add(const pugi::xml_node& appearance, const std::string& path, SceneBuilder& builder) {
  for (const pugi::xml_node& member : appearance.children()) {
    const std::string_view name = local_name(member);
    if (name != "surfaceDataMember" && name != "surfaceData") continue;  // of 2.0, of 3.0
    for (const pugi::xml_node& data : member.children()) {
      if (local_name(data) == "ParameterizedTexture") ZC_TRY(add_texture(data, path));
      if (local_name(data) == "X3DMaterial") ZC_TRY(add_material(data, path));
      if (local_name(data) == "GeoreferencedTexture") builder.note("georeferenced textures, left out");
    }
  }
  return {};
}

Status GmlAppearance::add_texture(const pugi::xml_node& data, const std::string& path) {
  GmlTexture texture;
  texture.image = gml_text(gml_child(data, "imageURI"));
  const std::string_view wrap = gml_text(gml_child(data, "wrapMode"));
  if (wrap == "mirror") texture.wrap = TextureWrap::kMirror;
  if (wrap == "none" || wrap == "clamp" || wrap == "border") texture.wrap = TextureWrap::kClamp;
  textures_.push_back(std::move(texture));
  // Of what two members paint, the first counts.
  for (const pugi::xml_node& child : data.children()) {
    if (local_name(child) == "target") {  // of 2.0: its coordinates lie in it
      texture_of_.try_emplace(reference(gml_attribute(child, "uri")), textures_.size() - 1);
      ZC_TRY(add_texcoords(gml_child(child, "TexCoordList"), path));
    }
    if (local_name(child) == "textureParameterization") {  // of 3.0: they lie beside it
      const pugi::xml_node association = gml_child(child, "TextureAssociation");
      texture_of_.try_emplace(reference(gml_text(gml_child(association, "target"))), textures_.size() - 1);
      ZC_TRY(add_texcoords(gml_child(gml_child(association, "textureParameterization"), "TexCoordList"), path));
    }
  }
  return {};
}

Status GmlAppearance::add_texcoords(const pugi::xml_node& lists, const std::string& path) {
  pugi::xml_node ring = gml_child(lists, "ring");  // of 3.0, in the order of the lists
  for (const pugi::xml_node& list : lists.children()) {
    if (local_name(list) != "textureCoordinates") continue;
    ZC_ASSIGN(const std::vector<double> numbers, gml_numbers(list, path));
    if (numbers.size() % 2 != 0) return gml_error(list, "an odd number of texture coordinates", path);
    std::vector<glm::vec2> uv;
    for (std::size_t i = 0; i < numbers.size(); i += 2) uv.emplace_back(numbers[i], numbers[i + 1]);
    const std::string_view own = gml_attribute(list, "ring");  // of 2.0
    texcoords_.try_emplace(reference(own.empty() ? gml_text(ring) : own), std::move(uv));
    do ring = ring.next_sibling();
    while (ring && local_name(ring) != "ring");
  }
  return {};
}

Status GmlAppearance::add_material(const pugi::xml_node& data, const std::string& path) {
  GmlMaterial material;
  material.name = gml_attribute(data, "id");
  if (const pugi::xml_node name = gml_child(data, "name")) material.name = gml_text(name);
  if (const pugi::xml_node diffuse = gml_child(data, "diffuseColor")) {
    ZC_ASSIGN(const std::vector<double> color, gml_numbers(diffuse, path));
    if (color.size() != 3) return gml_error(diffuse, "diffuseColor has not three numbers", path);
    for (int c = 0; c < 3; ++c)
      material.color[c] = srgb_to_linear(static_cast<float>(std::clamp(color[static_cast<std::size_t>(c)], 0.0, 1.0)));
  }
  if (const pugi::xml_node transparency = gml_child(data, "transparency")) {
    ZC_ASSIGN(const std::vector<double> value, gml_numbers(transparency, path));
    material.transparent = !value.empty() && value[0] > kTransparent;
  }
  materials_.push_back(std::move(material));
  for (const pugi::xml_node& target : data.children())
    if (local_name(target) == "target") material_of_.try_emplace(reference(gml_text(target)), materials_.size() - 1);
  return {};
}

const GmlTexture* GmlAppearance::texture(std::string_view surface) const {
  const std::size_t* index = find(texture_of_, surface);
  return index != nullptr ? &textures_[*index] : nullptr;
}

const GmlMaterial* GmlAppearance::material(std::string_view surface) const {
  const std::size_t* index = find(material_of_, surface);
  return index != nullptr ? &materials_[*index] : nullptr;
}

const std::vector<glm::vec2>* GmlAppearance::texcoords(std::string_view ring) const { return find(texcoords_, ring); }

}  // namespace zc
