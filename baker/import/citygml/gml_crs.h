// SPDX-License-Identifier: GPL-3.0-or-later
// Reference systems as srsName spells them: "EPSG:25832", "urn:ogc:def:crs:EPSG::25832",
// "http://…/def/crs/EPSG/0/25832", and compounds of a plane and a vertical system. Untrusted input. Thread-safe: no
// state.
#pragma once

#include <string_view>

namespace zc {

enum class GmlAxes {
  kProjected,          // metres: x, y, z
  kLatitudeLongitude,  // degrees, metres
  kLongitudeLatitude,
};

// Of names that are not known: projected.
GmlAxes axes_of_crs(std::string_view srs_name);

}  // namespace zc
