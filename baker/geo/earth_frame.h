// SPDX-License-Identifier: GPL-3.0-or-later
// Turns geocentric coordinates (EPSG:4978, WGS 84) into a local frame: x east, y north, z up, metres, at one point.
// Thread-safe: plain values.
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace zc {

struct Geodetic {
  double lon_deg = 0;
  double lat_deg = 0;
  double height_m = 0;  // above the ellipsoid
};

glm::dvec3 geocentric_of(const Geodetic& place);
// Whether a city can be there, at any height or depth that people built at.
bool is_on_earth(const glm::dvec3& geocentric);
// Not for points within some kilometres of the earth's centre.
Geodetic geodetic_of(const glm::dvec3& geocentric);

class EarthFrame {
 public:
  // The origin is rounded to the digits that crs() shows: its text defines the frame.
  explicit EarthFrame(const Geodetic& origin);
  // From the text that crs() gives; nothing for any other.
  static std::optional<EarthFrame> parse(std::string_view crs);
  [[nodiscard]] const glm::dmat4& from_geocentric() const { return from_geocentric_; }
  [[nodiscard]] std::string crs() const;

 private:
  Geodetic origin_;
  glm::dmat4 from_geocentric_;
};

}  // namespace zc
