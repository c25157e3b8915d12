// SPDX-License-Identifier: GPL-3.0-or-later
// WGS 84: NIMA TR8350.2, chapter 3.
#include "baker/geo/earth_frame.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>

namespace zc {
namespace {

constexpr double kSemiMajorM = 6'378'137.0;
constexpr double kFlattening = 1 / 298.257'223'563;
constexpr double kEccentricity2 = kFlattening * (2 - kFlattening);

constexpr double kHighest_m = 1e6;  // above it lies no city
constexpr double kNearest_m = 6.25e6;
constexpr double kFarthest_m = 6.48e6;

// + 0.0 turns -0 into 0.
double rounded(double value, double steps) { return std::round(value * steps) / steps + 0.0; }

// From the ellipsoid's axis to its surface, along the normal.
double normal_radius(double sin_lat) { return kSemiMajorM / std::sqrt(1 - kEccentricity2 * sin_lat * sin_lat); }

}  // namespace

glm::dvec3 geocentric_of(const Geodetic& place) {
  const double lon = glm::radians(place.lon_deg);
  const double lat = glm::radians(place.lat_deg);
  const double radius = normal_radius(std::sin(lat));
  const double from_axis = (radius + place.height_m) * std::cos(lat);
  return {from_axis * std::cos(lon), from_axis * std::sin(lon),
          (radius * (1 - kEccentricity2) + place.height_m) * std::sin(lat)};
}

bool is_on_earth(const glm::dvec3& geocentric) {
  const double from_centre = glm::length(geocentric);
  return from_centre > kNearest_m && from_centre < kFarthest_m;  // not NaN
}

Geodetic geodetic_of(const glm::dvec3& geocentric) {
  const double from_axis = std::hypot(geocentric.x, geocentric.y);
  double lat = std::atan2(geocentric.z, from_axis * (1 - kEccentricity2));
  // Each step is 150 times as close as the last.
  for (int step = 0; step < 8; ++step)
    lat = std::atan2(geocentric.z + kEccentricity2 * normal_radius(std::sin(lat)) * std::sin(lat), from_axis);
  const double sin_lat = std::sin(lat);
  const double height = from_axis * std::cos(lat) + geocentric.z * sin_lat -
                        kSemiMajorM * std::sqrt(1 - kEccentricity2 * sin_lat * sin_lat);
  return {glm::degrees(std::atan2(geocentric.y, geocentric.x)), glm::degrees(lat), height};
}

EarthFrame::EarthFrame(const Geodetic& origin)
    : origin_{rounded(origin.lon_deg, 1e7), rounded(origin.lat_deg, 1e7), rounded(origin.height_m, 1e3)} {
  const double lon = glm::radians(origin_.lon_deg);
  const double lat = glm::radians(origin_.lat_deg);
  const glm::dvec3 east(-std::sin(lon), std::cos(lon), 0);
  const glm::dvec3 north(-std::sin(lat) * std::cos(lon), -std::sin(lat) * std::sin(lon), std::cos(lat));
  const glm::dvec3 up(std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon), std::sin(lat));
  const glm::dmat3 turn = glm::transpose(glm::dmat3(east, north, up));
  from_geocentric_ = glm::dmat4(turn);
  from_geocentric_[3] = glm::dvec4(-(turn * geocentric_of(origin_)), 1);
}

std::optional<EarthFrame> EarthFrame::parse(std::string_view crs) {
  Geodetic origin;
  const auto take = [&](std::string_view before, double& number) {
    if (!crs.starts_with(before)) return false;
    crs.remove_prefix(before.size());
    const auto [end, failure] = std::from_chars(crs.data(), crs.data() + crs.size(), number);
    crs.remove_prefix(static_cast<std::size_t>(end - crs.data()));
    return failure == std::errc();
  };
  const bool is_one = take("ENU of EPSG:4978 at lon ", origin.lon_deg) && take(", lat ", origin.lat_deg) &&
                      take(", h ", origin.height_m) && crs == " m" && std::abs(origin.lon_deg) <= 360 &&
                      std::abs(origin.lat_deg) <= 90 && std::abs(origin.height_m) <= kHighest_m;
  return is_one ? std::optional<EarthFrame>(origin) : std::nullopt;
}

std::string EarthFrame::crs() const {
  std::array<char, 120> text{};
  std::snprintf(text.data(), text.size(), "ENU of EPSG:4978 at lon %.7f, lat %.7f, h %.3f m", origin_.lon_deg,
                origin_.lat_deg, origin_.height_m);
  return text.data();
}

}  // namespace zc
