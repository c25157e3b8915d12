// SPDX-License-Identifier: GPL-3.0-or-later
// Appearances of a CityGML document: what paints the surfaces of which ids. Source: OGC 12-019 (CityGML 2.0), clause 9;
// OGC 21-006r2 (CityGML 3.0 in GML), appearance.xsd.
// Borrows the document. Untrusted input. Thread-safe for const use.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "baker/import/shared/scene_builder.h"
#include "baker/scene/texture_image.h"
#include "base/result.h"

namespace zc {

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
  // Of one theme: the first that the document names. Notes what else there is.
  static Result<GmlAppearance> read(const pugi::xml_node& model, const std::string& path, SceneBuilder& builder);

  // Null where nothing paints the surface.
  [[nodiscard]] const GmlTexture* texture(std::string_view surface) const;
  [[nodiscard]] const GmlMaterial* material(std::string_view surface) const;
  // Of every point of a ring, v upwards; null where the ring has none.
  [[nodiscard]] const std::vector<glm::vec2>* texcoords(std::string_view ring) const;

 private:
  Status add(const pugi::xml_node& appearance, const std::string& path, SceneBuilder& builder);
  Status add_texture(const pugi::xml_node& data, const std::string& path);
  Status add_texcoords(const pugi::xml_node& lists, const std::string& path);
  Status add_material(const pugi::xml_node& data, const std::string& path);

  std::vector<GmlTexture> textures_;
  std::vector<GmlMaterial> materials_;
  std::map<std::string, std::size_t, std::less<>> texture_of_;
  std::map<std::string, std::size_t, std::less<>> material_of_;
  std::map<std::string, std::vector<glm::vec2>, std::less<>> texcoords_;
};

}  // namespace zc
