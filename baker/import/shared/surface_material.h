// SPDX-License-Identifier: GPL-3.0-or-later
// The appearance of CityJSON surfaces that nobody painted: semantics, object type or the way they face decide.
// Colours are linear. Thread-safe: no state.
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "baker/scene/scene.h"

namespace zc {

enum class Surface {
  kWall,
  kRoof,
  kGround,
  kCeiling,
  kFloor,
  kInstallation,
  kClosure,
  kWindow,
  kDoor,
  kTraffic,
  kAuxiliaryTraffic,
  kMarking,
  kRail,
  kWater,
  kPlant,
  kVegetation,
  kLand,
  kTerrain,
  kBridge,
  kTunnel,
  kFurniture,
  kOther,
};

// The surface that a semantic type names ("WallSurface", "+BuildingInstallation"); nothing for unknown names.
std::optional<Surface> surface_of_semantics(std::string_view type);

// For surfaces without semantics. `up` is the z of the unit normal.
Surface surface_of_object(std::string_view object_type, double up);

// Whether the object type is a part of a building: then walls and roofs take colours by the building's id.
bool is_building(std::string_view object_type);

ObjectKind kind_of_city_object(std::string_view object_type);

// Of models that have no types: "ground_1", "Road".
ObjectKind kind_of_name(std::string_view name);

// The appearance of a surface; `painted` is the mean colour of its texture or its material's colour.
struct Paint {
  std::optional<glm::vec3> color;
  std::optional<SurfaceTexture> texture;
  bool transparent = false;
  std::string name;  // of the image or material
};

Material surface_material(Surface surface, std::string_view object_type, std::string_view palette_key,
                          const Paint& paint);

}  // namespace zc
