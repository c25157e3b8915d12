// SPDX-License-Identifier: GPL-3.0-or-later
// Appearances of a CityGML document: what paints the surfaces of which ids. Source: OGC 12-019 (CityGML 2.0), clause 9.
// Borrows the document. Untrusted input. Thread-safe for const use.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "baker/scene/texture_image.h"
#include "base/result.h"

namespace zc {

// The name without its namespace's prefix.
std::string_view local_name(const pugi::xml_node& node);
// The first child or attribute of that local name; an empty one where there is none.
pugi::xml_node gml_child(const pugi::xml_node& node, std::string_view name);
std::string_view gml_attribute(const pugi::xml_node& node, std::string_view name);
std::string_view gml_text(const pugi::xml_node& node);
// Numbers between blanks or commas. Fails on anything else, naming the place.
Result<std::vector<double>> gml_numbers(const pugi::xml_node& node, const std::string& path);
Error gml_error(const pugi::xml_node& node, std::string message, const std::string& path);

struct GmlTexture {
  std::string image;
  TextureWrap wrap = TextureWrap::kRepeat;
};

struct GmlMaterial {
  std::string name;
  glm::vec3 color{0.8F};  // linear
  bool transparent = false;
};

class GmlAppearance {
 public:
  // Of one theme: the first that the document names. Adds to `other_themes` what else there is.
  static Result<GmlAppearance> read(const pugi::xml_node& model, const std::string& path, std::uint64_t& other_themes);

  // Null where nothing paints the surface.
  [[nodiscard]] const GmlTexture* texture(std::string_view surface) const;
  [[nodiscard]] const GmlMaterial* material(std::string_view surface) const;
  // Of every point of a ring, v upwards; null where the ring has none.
  [[nodiscard]] const std::vector<glm::vec2>* texcoords(std::string_view ring) const;

 private:
  Status add(const pugi::xml_node& appearance, const std::string& path);
  Status add_texture(const pugi::xml_node& data, const std::string& path);
  Status add_material(const pugi::xml_node& data, const std::string& path);

  std::vector<GmlTexture> textures_;
  std::vector<GmlMaterial> materials_;
  std::map<std::string, std::size_t, std::less<>> texture_of_;
  std::map<std::string, std::size_t, std::less<>> material_of_;
  std::map<std::string, std::vector<glm::vec2>, std::less<>> texcoords_;
};

}  // namespace zc
