// SPDX-License-Identifier: GPL-3.0-or-later
// Coordinate reference systems by the names that models and worlds give them: "EPSG:25832",
// "urn:ogc:def:crs:EPSG::7415", "http://…/def/crs/EPSG/0/25832", "EPSG:4326+5773", "urn:adv:crs:ETRS89_UTM32*…", CRS84,
// and the local frames of EarthFrame. Codes are looked up in PROJ's database, nothing else of a name reaches PROJ.
// Heights of systems without an ellipsoidal height count above sea level: EGM96, about a metre off.
// Names are untrusted input. Not thread-safe: a value and its copies belong to one thread at a time.
#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace zc {

class ReferenceSystem {
 public:
  enum class Kind : std::uint8_t {
    kNone,         // no name
    kUnknown,      // a name that says nothing
    kEastNorthUp,  // metres in the frame of EarthFrame
    kProjected,    // east, north, up
    kGeographic,   // degrees and metres
    kGeocentric,   // metres from the earth's centre
  };

  ReferenceSystem() = default;
  explicit ReferenceSystem(std::string_view name);

  [[nodiscard]] Kind kind() const { return kind_; }
  [[nodiscard]] const std::string& name() const { return name_; }
  // Whether a world can be in it: x east, y north, z up, in metres. Systems of which nothing is known are taken as
  // such.
  [[nodiscard]] bool is_metric() const;
  // Whether points have a place on the earth.
  [[nodiscard]] bool is_placed() const { return kind_ != Kind::kNone && kind_ != Kind::kUnknown; }
  // Of a geographic one: whether names of the axes give latitude before longitude.
  [[nodiscard]] bool latitude_first() const { return latitude_first_; }
  [[nodiscard]] bool is_same_as(const ReferenceSystem& other) const { return key_ == other.key_; }

  // WGS 84, metres from the earth's centre (EPSG:4978). Nothing where the system, or the place, has none.
  [[nodiscard]] std::optional<glm::dvec3> to_geocentric(const glm::dvec3& point) const;
  [[nodiscard]] std::optional<glm::dvec3> from_geocentric(const glm::dvec3& point) const;
  // Of a metric one: what turns offsets from `point` into geocentric coordinates, exact at that point.
  [[nodiscard]] std::optional<glm::dmat4> geocentric_at(const glm::dvec3& point) const;

 private:
  struct Conversion;

  Kind kind_ = Kind::kNone;
  std::string name_;
  std::string key_;  // the same for the same system
  bool latitude_first_ = false;
  double unit_m_ = 1;  // of a projected one
  struct LocalFrame {
    glm::dmat4 from_geocentric;
    glm::dmat4 to_geocentric;
  };
  std::optional<LocalFrame> frame_;  // of kEastNorthUp
  std::shared_ptr<const Conversion> conversion_;
};

}  // namespace zc
