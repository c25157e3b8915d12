// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/citygml/citygml_names.h"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <utility>

namespace zc {
namespace {

bool is_one_of(std::string_view name, std::initializer_list<std::string_view> names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// CityJSON's name, where it has another one.
std::string_view renamed(std::string_view name,
                         std::initializer_list<std::pair<std::string_view, std::string_view>> map) {
  for (const auto& [ours, theirs] : map)
    if (ours == name) return theirs;
  return name;
}

}  // namespace

GmlRole role_of(std::string_view name) {
  // The inner rings of polygons and the inner shells of solids are "interior" and no more.
  if ((name.starts_with("interior") && name != "interior") || name == "roomInstallation") return GmlRole::kInterior;
  if (is_one_of(name, {"Room", "BuildingRoom", "BuildingFurniture", "BridgeRoom", "BridgeFurniture", "HollowSpace",
                       "TunnelFurniture", "IntBuildingInstallation", "IntBridgeInstallation", "IntTunnelInstallation"}))
    return GmlRole::kInterior;
  if (is_one_of(name, {"ClearanceSpace", "GenericUnoccupiedSpace", "GenericLogicalSpace"})) return GmlRole::kEmptySpace;
  if (is_one_of(name, {"BuildingPart", "BuildingInstallation", "BuildingConstructiveElement", "BridgePart",
                       "BridgeInstallation", "BridgeConstructionElement", "BridgeConstructiveElement", "TunnelPart",
                       "TunnelInstallation", "TunnelConstructiveElement", "TINRelief", "Section", "Intersection",
                       "TrafficSpace", "AuxiliaryTrafficSpace", "Hole"}))
    return GmlRole::kPart;
  if (name == "appearance" || name == "boundedBySolid" || name.ends_with("TerrainIntersection") ||
      name.ends_with("TerrainIntersectionCurve") || name.ends_with("MultiCurve"))
    return GmlRole::kNoShape;
  return GmlRole::kPlain;
}

std::optional<int> lod_of(std::string_view name) {
  if (name == "tin") return kMaxLod;
  if (!name.starts_with("lod") || name.size() < 5 || name[3] < '0' || name[3] > '4') return std::nullopt;
  return name[3] - '0';
}

bool is_traffic_space(std::string_view name) {
  return is_one_of(name, {"Road", "Track", "Railway", "Waterway", "Square", "Section", "Intersection", "TrafficSpace",
                          "AuxiliaryTrafficSpace", "Hole"});
}

bool is_logical_space(std::string_view name) { return name == "Storey" || name == "BuildingUnit"; }

std::optional<Surface> surface_of_name(std::string_view name) {
  return surface_of_semantics(renamed(name, {{"WindowSurface", "Window"},
                                             {"DoorSurface", "Door"},
                                             {"AuxiliaryTrafficSpace", "AuxiliaryTrafficArea"},
                                             {"Marking", "TransportationMarking"},
                                             {"HoleSurface", "TransportationHole"}}));
}

std::string object_type(std::string_view name) {
  return std::string(renamed(name, {{"Square", "TransportSquare"},
                                    {"Track", "Road"},
                                    {"TransportationComplex", "Road"},
                                    {"Intersection", "Road"},
                                    {"Section", "Road"},
                                    {"ReliefFeature", "TINRelief"},
                                    {"WaterSurface", "WaterBody"},
                                    {"BridgeConstructionElement", "BridgeConstructiveElement"},
                                    {"GenericOccupiedSpace", "GenericCityObject"}}));
}

}  // namespace zc
