// SPDX-License-Identifier: GPL-3.0-or-later
// Turns geocentric coordinates (EPSG:4978, WGS 84) into a local frame: x east, y north, z up, metres, at one point.
// Thread-safe: plain values.
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <string>

namespace zc {

struct Geodetic {
  double lon_deg = 0;
  double lat_deg = 0;
  double height_m = 0;  // above the ellipsoid
};

glm::dvec3 geocentric_of(const Geodetic& place);
// Not for points within some kilometres of the earth's centre.
Geodetic geodetic_of(const glm::dvec3& geocentric);

class EarthFrame {
 public:
  // The origin is rounded to the digits that crs() shows: its text defines the frame.
  explicit EarthFrame(const Geodetic& origin);
  [[nodiscard]] const glm::dmat4& from_geocentric() const { return from_geocentric_; }
  [[nodiscard]] std::string crs() const;

 private:
  Geodetic origin_;
  glm::dmat4 from_geocentric_;
};

}  // namespace zc
