// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/citygml/gml_geometry.h"

#include <cmath>
#include <glm/mat4x4.hpp>
#include <string_view>

#include "baker/import/citygml/gml_xml.h"
#include "baker/import/shared/json_text.h"

namespace zc {
namespace {

// Of the model; where it says nothing, of the first element that does.
std::string_view crs_of(const pugi::xml_node& model) {
  std::string_view crs = gml_attribute(gml_child(gml_child(model, "boundedBy"), "Envelope"), "srsName");
  if (!crs.empty()) return crs;
  walk_gml(model, [&](const pugi::xml_node& node) {
    if (crs.empty()) crs = gml_attribute(node, "srsName");
    return crs.empty();
  });
  return crs;
}

}  // namespace

Status GmlGeometry::enter_model(const pugi::xml_node& model) {
  const std::string_view crs = crs_of(model);
  axes_ = axes_of_crs(crs);
  if (axes_ == GmlAxes::kProjected) return builder_.set_crs(std::string(crs), path_);
  return {};  // set with the first point, which the frame is made for
}

Result<std::vector<glm::dvec3>> GmlGeometry::points_of(const pugi::xml_node& ring) const {
  std::vector<glm::dvec3> points;
  for (const pugi::xml_node& child : ring.children()) {
    const std::string_view name = local_name(child);
    pugi::xml_node holder = child;
    if (name == "pointProperty")
      holder = gml_child(gml_child(child, "Point"), "pos");
    else if (name != "posList" && name != "pos" && name != "coordinates")
      continue;
    // Of the list itself, or of the geometry that it is part of.
    for (pugi::xml_node at = holder; at && local_name(at) != "CityModel"; at = at.parent()) {
      const std::string_view dimension = gml_attribute(at, "srsDimension");
      if (dimension.empty()) continue;
      if (dimension != "3")
        return gml_error(at,
                         "srsDimension is '" + one_line(dimension) +
                             "', expected three numbers a point; give the geometry heights or take it out",
                         path_);
      break;
    }
    ZC_ASSIGN(const std::vector<double> numbers, gml_numbers(holder, path_));
    if (numbers.size() % 3 != 0)
      return gml_error(child,
                       "coordinates that do not come in threes: " + std::to_string(numbers.size()) +
                           " numbers, expected x, y and z of every point",
                       path_);
    for (std::size_t i = 0; i < numbers.size(); i += 3) points.emplace_back(numbers[i], numbers[i + 1], numbers[i + 2]);
  }
  return points;
}

Result<std::vector<GmlRing>> GmlGeometry::rings_of(const pugi::xml_node& polygon) const {
  std::vector<GmlRing> rings;
  const auto add = [&](const pugi::xml_node& boundary) -> Status {
    const pugi::xml_node ring = gml_child(boundary, "LinearRing");
    if (!ring)
      return gml_error(boundary, "a boundary without a LinearRing, expected corners joined by straight lines", path_);
    ZC_ASSIGN(std::vector<glm::dvec3> points, points_of(ring));
    rings.push_back({ring, std::move(points)});
    return {};
  };
  const pugi::xml_node exterior = gml_child(polygon, "exterior");
  if (!exterior) return gml_error(polygon, "a polygon without an exterior", path_);
  ZC_TRY(add(exterior));
  for (const pugi::xml_node& interior : polygon.children())
    if (local_name(interior) == "interior") ZC_TRY(add(interior));
  return rings;
}

Result<glm::dvec3> GmlGeometry::to_world(const glm::dvec3& point, const pugi::xml_node& node) {
  if (axes_ == GmlAxes::kProjected) return point;
  const bool latitude_first = axes_ == GmlAxes::kLatitudeLongitude;
  const Geodetic place{latitude_first ? point.y : point.x, latitude_first ? point.x : point.y, point.z};
  if (!(std::abs(place.lat_deg) <= 90 && std::abs(place.lon_deg) <= 360 && std::abs(place.height_m) < 1e5))
    return gml_error(node,
                     "a place that is not on the earth: expected " +
                         std::string(latitude_first ? "latitude, longitude" : "longitude, latitude") +
                         " and height, as srsName asks for",
                     path_);
  if (!earth_) {
    earth_.emplace(place);
    builder_.remark("geographic coordinates, moved to a local frame");
  }
  if (!crs_set_) ZC_TRY(builder_.set_crs(earth_->crs(), path_));
  crs_set_ = true;
  return glm::dvec3(earth_->from_geocentric() * glm::dvec4(geocentric_of(place), 1));
}

}  // namespace zc
