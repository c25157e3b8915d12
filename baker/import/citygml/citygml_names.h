// SPDX-License-Identifier: GPL-3.0-or-later
// What the names of CityGML's elements mean for the shape of a city, in 1.0, 2.0 and 3.0 alike: no name means one thing
// in one version and another in the next. Thread-safe: no state.
// Source: OGC 12-019 (2.0); OGC 20-010 and 21-006r2 (3.0, model and GML encoding).
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "baker/import/shared/surface_material.h"

namespace zc {

enum class GmlRole {
  kPlain,
  kPart,        // a feature within another one, which chooses its own level of detail
  kInterior,    // a room or what stands in one
  kEmptySpace,  // nothing is there: its borders are not seen
  kNoShape,     // appearances, curves
};
GmlRole role_of(std::string_view name);

// 0 to 4 for "lod3Solid"; nothing for other names. Relief has it elsewhere, and only one.
inline constexpr int kMaxLod = 3;
std::optional<int> lod_of(std::string_view name);

// A space that traffic moves in: its solids and closure surfaces enclose air.
bool is_traffic_space(std::string_view name);

// A space that is a part of a building in name alone, a storey or a flat: parts within it have the shape.
bool is_logical_space(std::string_view name);

// The surface that an element of that name is, or is made of.
std::optional<Surface> surface_of_name(std::string_view name);

// As surface_of_object() and kind_of_city_object() know the feature.
std::string object_type(std::string_view name);

}  // namespace zc
