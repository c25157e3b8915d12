// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/shared/world_placement.h"

#include <glm/matrix.hpp>
#include <limits>
#include <utility>

#include "base/text.h"

namespace zc {
namespace {

constexpr std::size_t kNameBytes = 80;  // of a reference system, in a message

std::string shown(const ReferenceSystem& system) { return "'" + printable(system.name(), kNameBytes) + "'"; }

}  // namespace

Status WorldPlacement::enter_file(UpAxis up, const std::string& path) {
  turn_ = glm::dmat3(upright(asked_.up.value_or(up)) * glm::transpose(upright(up))) * asked_.scale;
  moves_ = turn_ != glm::dmat3(1) || asked_.offset_m != glm::dvec3(0);
  source_ = metric_ = {};
  gives_metric_ = converts_ = false;
  if (asked_.crs.value_or("").empty()) return {};
  ++crs_named_;
  source_ = system_of(*asked_.crs);
  return enter_system(source_, path);
}

Status WorldPlacement::set_crs(const std::string& of_file, const std::string& path) {
  if (of_file.empty()) return {};
  const ReferenceSystem& system = system_of(of_file);
  if (asked_.crs) {
    if (asked_.crs->empty() || system.kind() != ReferenceSystem::Kind::kEastNorthUp) return {};
    return Error{ErrorCode::kArgument,
                 "stands on the earth by its own coordinates, --crs " + *asked_.crs + " does not apply to it", path};
  }
  ++crs_named_;
  source_ = system;
  return enter_system(system, path);
}

const ReferenceSystem& WorldPlacement::system_of(const std::string& name) {
  const auto known = systems_.find(name);
  return known != systems_.end() ? known->second : systems_.emplace(name, ReferenceSystem(name)).first->second;
}

// What is not metric waits for its first point, which chooses the local frame.
Status WorldPlacement::enter_system(const ReferenceSystem& system, const std::string& path) {
  metric_ = system;
  converts_ = false;
  if (!system.is_metric()) return {};
  if (world_.kind() == ReferenceSystem::Kind::kNone) world_ = system;
  if (world_.is_same_as(system)) return {};
  converts_ = system.is_placed() && world_.is_placed();
  if (converts_) return {};
  const ReferenceSystem& unknown = system.is_placed() ? world_ : system;
  return Error{ErrorCode::kUnsupported,
               "reference system " + shown(system) + " differs from " + shown(world_) +
                   " of an earlier input, and where " + shown(unknown) +
                   " lies is not known; name it with --crs EPSG:N, or bake the inputs apart",
               path};
}

const EarthFrame& WorldPlacement::earth(const Geodetic& place) {
  if (!earth_) earth_.emplace(place);
  return *earth_;
}

Result<glm::dvec3> WorldPlacement::to_earth_frame(const glm::dvec3& point, const std::string& path) {
  const auto on_earth = source_.to_geocentric(point);
  if (!on_earth || !is_on_earth(*on_earth)) {
    const bool geographic = source_.kind() == ReferenceSystem::Kind::kGeographic;
    return Error{ErrorCode::kFormat,
                 "a place that is not on the earth: expected " +
                     std::string(!geographic                ? "coordinates"
                                 : source_.latitude_first() ? "latitude, longitude and height"
                                                            : "longitude, latitude and height") +
                     " of " + shown(source_),
                 path};
  }
  const EarthFrame& frame = earth(geodetic_of(*on_earth));
  if (!metric_.is_metric()) ZC_TRY(enter_system(system_of(frame.crs()), path));
  return glm::dvec3(frame.from_geocentric() * glm::dvec4(*on_earth, 1));
}

Result<glm::dvec3> WorldPlacement::to_metric(const glm::dvec3& point, const std::string& path) {
  gives_metric_ = true;
  if (source_.is_metric()) return point;
  return to_earth_frame(point, path);
}

Status WorldPlacement::to_world(std::vector<glm::dvec3>& points, const std::string& path) {
  for (glm::dvec3& point : points) {
    if (moves_) point = turn_ * point + asked_.offset_m;
    if (from_degrees()) {
      ZC_ASSIGN(point, to_earth_frame(point, path));
    }
    if (!converts_) continue;
    const auto on_earth = metric_.to_geocentric(point);
    const auto there = on_earth ? world_.from_geocentric(*on_earth) : std::nullopt;
    point = there.value_or(glm::dvec3(std::numeric_limits<double>::quiet_NaN()));
  }
  return {};
}

}  // namespace zc
