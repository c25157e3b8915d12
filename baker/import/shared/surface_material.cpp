// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/shared/surface_material.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <utility>

#include "base/text.h"

namespace zc {
namespace {

struct Appearance {
  const char* name;
  glm::vec3 color;
  float roughness;
};

constexpr float kGlassTint = 0.3F;

const Appearance& appearance_of(Surface surface) {
  // In the order of the enumeration.
  static const std::array<Appearance, 22> appearances = {{
      {"WallSurface", {0.55F, 0.51F, 0.45F}, 0.85F},
      {"RoofSurface", {0.28F, 0.12F, 0.08F}, 0.75F},
      {"GroundSurface", {0.20F, 0.19F, 0.18F}, 0.95F},
      {"OuterCeilingSurface", {0.50F, 0.49F, 0.47F}, 0.90F},
      {"OuterFloorSurface", {0.32F, 0.31F, 0.30F}, 0.80F},
      {"BuildingInstallation", {0.24F, 0.24F, 0.25F}, 0.55F},
      {"ClosureSurface", {0.45F, 0.44F, 0.42F}, 0.90F},
      {"Window", {0.02F, 0.03F, 0.04F}, 0.03F},
      {"Door", {0.16F, 0.08F, 0.04F}, 0.50F},
      {"TrafficArea", {0.030F, 0.030F, 0.032F}, 0.04F},  // wet asphalt
      {"AuxiliaryTrafficArea", {0.20F, 0.19F, 0.18F}, 0.60F},
      {"TransportationMarking", {0.65F, 0.65F, 0.63F}, 0.30F},
      {"Railway", {0.13F, 0.11F, 0.10F}, 0.80F},
      {"WaterBody", {0.01F, 0.02F, 0.03F}, 0.02F},
      {"PlantCover", {0.07F, 0.13F, 0.04F}, 0.95F},
      {"SolitaryVegetationObject", {0.05F, 0.11F, 0.03F}, 0.95F},
      {"LandUse", {0.17F, 0.18F, 0.12F}, 0.95F},
      {"TINRelief", {0.16F, 0.16F, 0.11F}, 0.95F},
      {"Bridge", {0.38F, 0.37F, 0.35F}, 0.70F},
      {"Tunnel", {0.28F, 0.28F, 0.27F}, 0.75F},
      {"CityFurniture", {0.18F, 0.19F, 0.20F}, 0.40F},
      {"GenericCityObject", {0.40F, 0.39F, 0.37F}, 0.80F},
  }};
  return appearances[static_cast<std::size_t>(surface)];
}

// Plaster, brick and stone as central European towns have them.
constexpr std::array<glm::vec3, 9> kFacades = {{
    {0.70F, 0.64F, 0.50F},  // cream
    {0.66F, 0.47F, 0.22F},  // ochre
    {0.60F, 0.57F, 0.52F},  // light grey
    {0.62F, 0.36F, 0.24F},  // terracotta
    {0.72F, 0.70F, 0.66F},  // white
    {0.30F, 0.12F, 0.08F},  // brick
    {0.44F, 0.50F, 0.38F},  // sage
    {0.63F, 0.50F, 0.42F},  // pale rose
    {0.36F, 0.42F, 0.48F},  // slate blue
}};

struct Roof {
  glm::vec3 color;
  float roughness;
};
constexpr std::array<Roof, 6> kRoofs = {{
    {{0.33F, 0.10F, 0.05F}, 0.75F},  // tile red
    {{0.27F, 0.08F, 0.05F}, 0.75F},  // old tile
    {{0.09F, 0.10F, 0.11F}, 0.45F},  // slate
    {{0.17F, 0.09F, 0.06F}, 0.80F},  // brown
    {{0.36F, 0.15F, 0.08F}, 0.75F},  // light tile
    {{0.16F, 0.16F, 0.16F}, 0.60F},  // grey sheet
}};

// FNV-1a, then mixed so that neighbouring ids fall apart.
std::uint64_t hash_of(std::string_view text) {
  std::uint64_t hash = 0xCBF29CE484222325ULL;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3ULL;
  hash ^= hash >> 33U;
  hash *= 0xFF51AFD7ED558CCDULL;
  return hash ^ (hash >> 33U);
}

bool can_be_glass(Surface surface) {
  switch (surface) {
    case Surface::kWindow:
    case Surface::kDoor:
    case Surface::kWall:
    case Surface::kRoof:
    case Surface::kInstallation:
    case Surface::kClosure:
    case Surface::kOther:
      return true;
    default:
      return false;
  }
}

Surface by_direction(double up) {
  if (up > 0.3) return Surface::kRoof;
  if (up < -0.7) return Surface::kGround;
  return Surface::kWall;
}

}  // namespace

std::optional<Surface> surface_of_semantics(std::string_view type) {
  static constexpr std::array<std::pair<std::string_view, Surface>, 24> names = {{
      {"WallSurface", Surface::kWall},
      {"RoofSurface", Surface::kRoof},
      {"GroundSurface", Surface::kGround},
      {"Window", Surface::kWindow},
      {"Door", Surface::kDoor},
      {"OuterCeilingSurface", Surface::kCeiling},
      {"OuterFloorSurface", Surface::kFloor},
      {"BuildingInstallation", Surface::kInstallation},
      {"ClosureSurface", Surface::kClosure},
      {"InteriorWallSurface", Surface::kWall},
      {"CeilingSurface", Surface::kCeiling},
      {"FloorSurface", Surface::kFloor},
      {"TrafficArea", Surface::kTraffic},
      {"AuxiliaryTrafficArea", Surface::kAuxiliaryTraffic},
      {"TransportationMarking", Surface::kMarking},
      {"TransportationHole", Surface::kFurniture},
      {"Road", Surface::kTraffic},
      {"TransportSquare", Surface::kTraffic},
      {"Railway", Surface::kRail},
      {"WaterSurface", Surface::kWater},
      {"WaterGroundSurface", Surface::kLand},
      {"WaterClosureSurface", Surface::kWater},
      {"WaterBody", Surface::kWater},
      {"CityFurniture", Surface::kFurniture},
  }};
  if (type.starts_with('+')) type.remove_prefix(1);
  for (const auto& [name, surface] : names)
    if (name == type) return surface;
  return std::nullopt;
}

bool is_building(std::string_view object_type) { return object_type.starts_with("Building"); }

Surface surface_of_object(std::string_view object_type, double up) {
  static constexpr std::array<std::pair<std::string_view, Surface>, 20> names = {{
      {"BuildingInstallation", Surface::kInstallation},
      {"BuildingFurniture", Surface::kFurniture},
      {"Road", Surface::kTraffic},
      {"TransportSquare", Surface::kTraffic},
      {"Railway", Surface::kRail},
      {"Waterway", Surface::kWater},
      {"WaterBody", Surface::kWater},
      {"PlantCover", Surface::kPlant},
      {"SolitaryVegetationObject", Surface::kVegetation},
      {"LandUse", Surface::kLand},
      {"TINRelief", Surface::kTerrain},
      {"Bridge", Surface::kBridge},
      {"BridgePart", Surface::kBridge},
      {"BridgeInstallation", Surface::kBridge},
      {"BridgeConstructiveElement", Surface::kBridge},
      {"Tunnel", Surface::kTunnel},
      {"TunnelPart", Surface::kTunnel},
      {"TunnelInstallation", Surface::kTunnel},
      {"CityFurniture", Surface::kFurniture},
      {"GenericCityObject", Surface::kOther},
  }};
  if (object_type.starts_with('+')) object_type.remove_prefix(1);
  for (const auto& [name, surface] : names)
    if (name == object_type) return surface;
  return is_building(object_type) ? by_direction(up) : Surface::kOther;
}

ObjectKind kind_of_city_object(std::string_view object_type) {
  static constexpr std::array<std::string_view, 8> grounds = {"TINRelief",       "LandUse",  "Road",      "Railway",
                                                              "TransportSquare", "Waterway", "WaterBody", "PlantCover"};
  for (const std::string_view name : grounds)
    if (name == object_type) return ObjectKind::kGround;
  return ObjectKind::kObject;
}

ObjectKind kind_of_name(std::string_view name) {
  static constexpr std::array<std::string_view, 7> grounds = {"ground",   "road",         "terrain", "street",
                                                              "sidewalk", "plaza_ground", "water"};
  const std::string lower_name = lower(name);
  for (const std::string_view prefix : grounds)
    if (lower_name.starts_with(prefix)) return ObjectKind::kGround;
  return ObjectKind::kObject;
}

Material surface_material(Surface surface, std::string_view object_type, std::string_view palette_key,
                          const Paint& paint) {
  const bool glass = surface == Surface::kWindow || (paint.transparent && can_be_glass(surface));
  const Appearance& appearance = appearance_of(glass ? Surface::kWindow : surface);
  Material material{.name = appearance.name,
                    .base_color = appearance.color,
                    .roughness = appearance.roughness,
                    .surface = appearance.name};
  if (paint.color) {
    material.name.append(" ").append(paint.name);
    // Glass stays dark and smooth: an image only tints it, a plain material colour tints what is see-through.
    if (glass && !paint.texture) {
      material.name = appearance.name;
      return material;
    }
    material.base_color = glass ? glm::mix(appearance.color, *paint.color, kGlassTint) : *paint.color;
    material.texture = paint.texture;
    if (glass) {
      material.texture->factor = glm::vec3(kGlassTint);
      material.texture->offset = appearance.color * (1 - kGlassTint);
    }
    return material;
  }
  if (glass || !is_building(object_type)) return material;
  const std::uint64_t hash = hash_of(palette_key);
  if (surface == Surface::kWall) {
    const std::size_t pick = hash % kFacades.size();
    material.name.append(" ").append(std::to_string(pick));
    material.base_color = kFacades[pick];
  } else if (surface == Surface::kRoof) {
    const std::size_t pick = (hash >> 32U) % kRoofs.size();
    material.name.append(" ").append(std::to_string(pick));
    material.base_color = kRoofs[pick].color;
    material.roughness = kRoofs[pick].roughness;
  }
  return material;
}

}  // namespace zc
