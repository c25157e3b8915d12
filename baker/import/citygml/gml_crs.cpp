// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/citygml/gml_crs.h"

#include <algorithm>
#include <array>
#include <string>

#include "base/text.h"

namespace zc {
namespace {

// Geographic systems by their EPSG codes: latitude, longitude and, in all but the two-dimensional ones, height.
constexpr std::array<std::string_view, 8> kGeographic = {"4326", "4258", "4937", "4979",
                                                         "6667", "6668", "6697", "7423"};

}  // namespace

GmlAxes axes_of_crs(std::string_view srs_name) {
  // Of a compound, the plane system comes first: "urn:ogc:def:crs,crs:EPSG::4326,crs:EPSG::5773", "EPSG:4326+5773",
  // "http://…/crs-compound?1=http://…/EPSG/0/4326&2=…".
  const std::string name = lower(srs_name);
  for (std::string_view rest = name; !rest.empty();) {
    const std::string_view part = rest.substr(0, rest.find_first_of(",+&"));
    rest.remove_prefix(std::min(rest.size(), part.size() + 1));
    if (part.ends_with("crs84") || part.ends_with("crs84h")) return GmlAxes::kLongitudeLatitude;
    const std::string_view code = part.substr(part.find_last_not_of("0123456789") + 1);
    if (code.empty()) continue;
    const bool known = std::find(kGeographic.begin(), kGeographic.end(), code) != kGeographic.end();
    return known ? GmlAxes::kLatitudeLongitude : GmlAxes::kProjected;
  }
  return GmlAxes::kProjected;
}

}  // namespace zc
