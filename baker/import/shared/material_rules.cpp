// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/shared/material_rules.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "baker/import/shared/json_text.h"

namespace zc {
namespace {

using json = nlohmann::json;

constexpr float kWetRoughness = 0.04F;
constexpr float kWetDarkness = 0.5F;  // water fills the pores that scatter light

bool gets_wet(const Material& material, ObjectKind kind) {
  static constexpr std::array<std::string_view, 5> surfaces = {"TrafficArea", "AuxiliaryTrafficArea",
                                                               "TransportationMarking", "LandUse", "TINRelief"};
  if (material.surface.empty()) return kind == ObjectKind::kGround;  // glTF: by the names of nodes
  return std::ranges::find(surfaces, material.surface) != surfaces.end();
}

Status read_text(const json& rule, const char* key, std::string& out, const std::string& where,
                 const std::string& path) {
  const json* value = find_member(rule, key);
  if (value == nullptr) return {};
  if (!value->is_string()) return Error{ErrorCode::kFormat, where + ": " + key + " is no text", path};
  out = value->get<std::string>();
  return {};
}

Status read_share(const json& rule, const char* key, std::optional<float>& out, const std::string& where,
                  const std::string& path) {
  const json* value = find_member(rule, key);
  if (value == nullptr) return {};
  if (!value->is_number() || !(value->get<double>() >= 0 && value->get<double>() <= 1))
    return Error{ErrorCode::kFormat, where + ": " + key + " is no number from 0 to 1", path};
  out = value->get<float>();
  return {};
}

Result<MaterialRule> read_rule(const json& rule, const std::string& where, const std::string& path) {
  static constexpr std::array<std::string_view, 7> keys = {"surface",    "object",    "name",    "material",
                                                           "base_color", "roughness", "metallic"};
  if (!rule.is_object()) return Error{ErrorCode::kFormat, where + " is no object", path};
  for (const auto& [key, value] : rule.items())
    if (std::ranges::find(keys, key) == keys.end())
      return Error{ErrorCode::kFormat,
                   where + ": unknown member '" + one_line(key) +
                       "', expected surface, object, name, material, base_color, roughness, metallic",
                   path};
  MaterialRule out;
  ZC_TRY(read_text(rule, "surface", out.surface, where, path));
  ZC_TRY(read_text(rule, "object", out.object, where, path));
  ZC_TRY(read_text(rule, "name", out.name, where, path));
  ZC_TRY(read_text(rule, "material", out.material, where, path));
  ZC_TRY(read_share(rule, "roughness", out.roughness, where, path));
  ZC_TRY(read_share(rule, "metallic", out.metallic, where, path));
  if (const json* color = find_member(rule, "base_color"); color != nullptr) {
    const auto numbers = as_numbers(*color, 3);
    const auto within = [](double c) { return c >= 0 && c <= 1; };
    if (!numbers || !std::ranges::all_of(*numbers, within))
      return Error{ErrorCode::kFormat, where + ": base_color is no list of three numbers from 0 to 1", path};
    out.base_color = glm::vec3((*numbers)[0], (*numbers)[1], (*numbers)[2]);
  }
  if (!out.base_color && !out.roughness && !out.metallic)
    return Error{ErrorCode::kFormat, where + " changes nothing: give base_color, roughness or metallic", path};
  return out;
}

}  // namespace

bool fits_pattern(std::string_view pattern, std::string_view text) {
  std::size_t p = 0;
  std::size_t t = 0;
  std::size_t star = std::string_view::npos;  // the last one, and where what it stands for ends
  std::size_t end = 0;
  while (t < text.size()) {
    if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == text[t]) && pattern[p] != '*') {
      ++p;
      ++t;
    } else if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      end = t;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      t = ++end;
    } else {
      return false;
    }
  }
  return pattern.find_first_not_of('*', p) == std::string_view::npos;
}

Result<MaterialRules> MaterialRules::parse(std::string_view text, const std::string& path) {
  ZC_ASSIGN(const json document, parse_small_json(text, path));
  const json* list = find_member(document, "materials");
  if (list == nullptr || !list->is_array())
    return Error{ErrorCode::kFormat, "has no list \"materials\" of rules; docs/inputs.md shows one", path};
  MaterialRules rules;
  for (std::size_t i = 0; i < list->size(); ++i) {
    ZC_ASSIGN(MaterialRule rule, read_rule((*list)[i], "materials[" + std::to_string(i) + "]", path));
    rules.rules_.push_back(std::move(rule));
  }
  return rules;
}

Material MaterialRules::apply(const Material& material, std::string_view object_type, std::string_view name,
                              ObjectKind kind) const {
  const auto fits = [](const std::string& pattern, std::string_view text) {
    return pattern.empty() || fits_pattern(pattern, text);
  };
  Material out = material;
  for (const MaterialRule& rule : rules_) {
    if (!fits(rule.surface, material.surface) || !fits(rule.object, object_type) || !fits(rule.name, name) ||
        !fits(rule.material, material.name))
      continue;
    if (rule.base_color) {
      out.base_color = *rule.base_color;
      out.texture.reset();
    }
    out.roughness = rule.roughness.value_or(out.roughness);
    out.metallic = rule.metallic.value_or(out.metallic);
    break;
  }
  if (wet_ground_ && gets_wet(material, kind) && out.roughness > kWetRoughness) {
    out.roughness = kWetRoughness;
    out.base_color *= kWetDarkness;
    if (out.texture) {
      out.texture->factor *= kWetDarkness;
      out.texture->offset *= kWetDarkness;
    }
  }
  return out;
}

}  // namespace zc
