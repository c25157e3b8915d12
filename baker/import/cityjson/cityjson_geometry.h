// SPDX-License-Identifier: GPL-3.0-or-later
// One CityJSON geometry into triangles: every surface of a MultiSurface, CompositeSurface, Solid, MultiSolid or
// CompositeSolid, with the material that its texture, material or semantics give it.
// Untrusted input: every index and nesting is checked. Not thread-safe (shares the builder and the image cache).
#pragma once

#include <glm/mat4x4.hpp>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "baker/import/cityjson/cityjson_source.h"
#include "baker/import/shared/scene_builder.h"
#include "baker/import/shared/texture_images.h"

namespace zc {

struct CityContext {
  const CitySource& source;
  std::span<const glm::dvec3> vertices;
  const CityAppearance& appearance;
  TextureImages& images;
  SceneBuilder& builder;
};

struct CityObjectRef {
  const std::string& id;           // named in errors
  const std::string& type;         // "Building", …
  const std::string& palette_key;  // façade and roof colours go by it
};

// Whether the geometry type has surfaces (points and lines have none). Nothing for an unknown type.
std::optional<bool> has_surfaces(const std::string& geometry_type);

// Appends to `mesh`. `placement`, when given, moves the vertices (geometry templates).
Status add_city_geometry(const nlohmann::json& geometry, const CityContext& context, const CityObjectRef& object,
                         const glm::dmat4* placement, ObjectMesh& mesh);

}  // namespace zc
