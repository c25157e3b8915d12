// SPDX-License-Identifier: GPL-3.0-or-later
// What surfaces are made of, where the user knows better than the data: rules by surface type, object type, object name
// and source material (docs/inputs.md, Materials). Untrusted input: the file of rules. Thread-safe: plain values.
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "baker/scene/scene.h"
#include "base/result.h"

namespace zc {

// Patterns: * stands for any text, ? for one character; empty for everything.
struct MaterialRule {
  std::string surface;                  // "WallSurface", "TrafficArea": as in docs/inputs.md; of glTF nothing
  std::string object;                   // type of the city object: "Building"; of glTF nothing
  std::string name;                     // id or name of the object
  std::string material;                 // name of the material, as in the input
  std::optional<glm::vec3> base_color;  // linear; takes the place of a texture
  std::optional<float> roughness;
  std::optional<float> metallic;
};

class MaterialRules {
 public:
  // Fails on unknown members, values out of range and rules that change nothing; named by their place in the list.
  static Result<MaterialRules> parse(std::string_view json, const std::string& path);
  // Ground and roads are dark and smooth, as after rain; after the other rules.
  void wet_ground() { wet_ground_ = true; }

  [[nodiscard]] bool empty() const { return rules_.empty() && !wet_ground_; }
  // The first rule that fits counts. `surface` is Material::surface.
  [[nodiscard]] Material apply(const Material& material, std::string_view object_type, std::string_view name,
                               ObjectKind kind) const;

 private:
  std::vector<MaterialRule> rules_;
  bool wet_ground_ = false;
};

// Whether all of `text` fits the pattern.
bool fits_pattern(std::string_view pattern, std::string_view text);

}  // namespace zc
