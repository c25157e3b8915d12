// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/citygml/citygml_appearance.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "baker/import/shared/json_text.h"

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

// Appearances lie in the model and in its features, at any depth; calls visit(element) for each.
template <class Visit>
Status for_appearances(const pugi::xml_node& model, const Visit& visit) {
  // Document order without recursion: files nest as they like.
  for (pugi::xml_node node = model.first_child(); node && node != model;) {
    const bool found = local_name(node) == "Appearance";
    if (found) ZC_TRY(visit(node));
    if (!found && node.first_child()) {
      node = node.first_child();
      continue;
    }
    while (node && node != model && !node.next_sibling()) node = node.parent();
    if (node && node != model) node = node.next_sibling();
  }
  return {};
}

}  // namespace

std::string_view local_name(const pugi::xml_node& node) {
  const std::string_view name = node.name();
  const std::size_t colon = name.find(':');
  return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

pugi::xml_node gml_child(const pugi::xml_node& node, std::string_view name) {
  for (const pugi::xml_node& child : node.children())
    if (local_name(child) == name) return child;
  return {};
}

std::string_view gml_attribute(const pugi::xml_node& node, std::string_view name) {
  for (const pugi::xml_attribute& attribute : node.attributes()) {
    const std::string_view full = attribute.name();
    const std::size_t colon = full.find(':');
    if ((colon == std::string_view::npos ? full : full.substr(colon + 1)) == name) return attribute.value();
  }
  return {};
}

std::string_view gml_text(const pugi::xml_node& node) {
  std::string_view text = node.child_value();
  const std::string_view blank = " \t\r\n";
  const std::size_t first = text.find_first_not_of(blank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blank) - first + 1);
}

Error gml_error(const pugi::xml_node& node, std::string message, const std::string& path) {
  return {ErrorCode::kFormat, std::move(message), path, static_cast<std::int64_t>(node.offset_debug())};
}

Result<std::vector<double>> gml_numbers(const pugi::xml_node& node, const std::string& path) {
  std::vector<double> numbers;
  const std::string_view text = node.child_value();
  for (std::size_t at = 0; at < text.size();) {
    if (std::string_view(" \t\r\n,").find(text[at]) != std::string_view::npos) {
      ++at;
      continue;
    }
    const char* begin = text.data() + at + (text[at] == '+' ? 1 : 0);
    double value = 0;
    const auto [end, failure] = std::from_chars(begin, text.data() + text.size(), value);
    if (failure != std::errc())
      return gml_error(node, "'" + one_line(text.substr(at, 24)) + "' in " + one_line(node.name()) + " is no number",
                       path);
    numbers.push_back(value);
    at = static_cast<std::size_t>(end - text.data());
  }
  return numbers;
}

Result<GmlAppearance> GmlAppearance::read(const pugi::xml_node& model, const std::string& path,
                                          std::uint64_t& other_themes) {
  GmlAppearance out;
  std::optional<std::string> theme;
  ZC_TRY(for_appearances(model, [&](const pugi::xml_node& appearance) -> Status {
    const std::string own(gml_text(gml_child(appearance, "theme")));
    if (!theme) theme = own;
    if (*theme != own) {
      ++other_themes;
      return {};
    }
    return out.add(appearance, path);
  }));
  return out;
}

Status GmlAppearance::add(const pugi::xml_node& appearance, const std::string& path) {
  for (const pugi::xml_node& member : appearance.children()) {
    if (local_name(member) != "surfaceDataMember") continue;
    for (const pugi::xml_node& data : member.children()) {
      if (local_name(data) == "ParameterizedTexture") ZC_TRY(add_texture(data, path));
      if (local_name(data) == "X3DMaterial") ZC_TRY(add_material(data, path));
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
  for (const pugi::xml_node& target : data.children()) {
    if (local_name(target) != "target") continue;
    // Of what two members paint, the first counts.
    texture_of_.try_emplace(reference(gml_attribute(target, "uri")), textures_.size() - 1);
    for (const pugi::xml_node& list : gml_child(target, "TexCoordList").children()) {
      if (local_name(list) != "textureCoordinates") continue;
      ZC_ASSIGN(const std::vector<double> numbers, gml_numbers(list, path));
      if (numbers.size() % 2 != 0) return gml_error(list, "an odd number of texture coordinates", path);
      std::vector<glm::vec2> uv;
      for (std::size_t i = 0; i < numbers.size(); i += 2) uv.emplace_back(numbers[i], numbers[i + 1]);
      texcoords_.try_emplace(reference(gml_attribute(list, "ring")), std::move(uv));
    }
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
