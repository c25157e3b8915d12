// SPDX-License-Identifier: GPL-3.0-or-later
// Parts of a CityJSON document that its geometry refers to: vertices, appearance, templates; and where faults lie.
// Borrows the JSON and its text. Untrusted input. Thread-safe for const use.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "baker/import/shared/input_files.h"
#include "baker/scene/texture_image.h"
#include "base/result.h"

namespace zc {

struct CitySource {
  std::string path;
  std::string_view text;         // of the document or line
  std::int64_t base_offset = 0;  // of `text` in the file
  std::filesystem::path model;   // beside which images lie: `path`, or nothing for a stream
  const InputFiles& files;       // that these are read from

  // What a texture calls `name` (uri.h).
  [[nodiscard]] Result<std::filesystem::path> image_file(const std::string& name) const;
  [[nodiscard]] Error error(std::string message) const;
  // Names the object and the place of its first mention.
  [[nodiscard]] Error object_error(const std::string& id, const std::string& message) const;
};

struct CityTransform {
  glm::dvec3 scale{1};
  glm::dvec3 translate{0};
};

struct CityTexture {
  std::string image;
  TextureWrap wrap = TextureWrap::kRepeat;
};

struct CityMaterial {
  std::string name;
  glm::vec3 color{0.8F};  // linear
  bool transparent = false;
};

struct CityAppearance {
  std::vector<CityTexture> textures;
  std::vector<CityMaterial> materials;
  std::vector<glm::vec2> texcoords;  // v upwards
  std::string texture_theme;         // the default ones, may be empty
  std::string material_theme;
};

Result<CityTransform> read_city_transform(const nlohmann::json& document, const CitySource& source);

// Fails on anything but triples of numbers, and on coordinates that are not finite once transformed.
Result<std::vector<glm::dvec3>> read_city_vertices(const nlohmann::json& list, const CityTransform& transform,
                                                   const CitySource& source);

// Empty when the document has no appearance.
Result<CityAppearance> read_city_appearance(const nlohmann::json& document, const CitySource& source);

}  // namespace zc
