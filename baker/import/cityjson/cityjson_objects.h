// SPDX-License-Identifier: GPL-3.0-or-later
// The city objects of one CityJSON document or feature line: which geometry of each counts, and which objects join.
// Untrusted input.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "baker/import/cityjson/cityjson_source.h"
#include "baker/import/shared/scene_builder.h"
#include "baker/import/shared/texture_images.h"

namespace zc {

// What a CityJSONSeq's first line, or the document itself, contains for all objects.
struct CityHeader {
  CityTransform transform;
  CityAppearance appearance;
  std::vector<nlohmann::json> templates;
  std::vector<glm::dvec3> template_vertices;
};

Status add_city_objects(const nlohmann::json& document, const CityHeader& header, const CitySource& source,
                        TextureImages& images, SceneBuilder& builder);

}  // namespace zc
