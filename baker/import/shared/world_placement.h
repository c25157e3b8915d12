// SPDX-License-Identifier: GPL-3.0-or-later
// Where inputs stand in the world: from the coordinates of a file, by what the caller says of them, to those of the
// world, metres, z up. The first input with a reference system chooses the world's; where it is not one of metres, a
// local frame at its first point. Order of calls alone decides the result. Not thread-safe.
#pragma once

#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "baker/geo/earth_frame.h"
#include "baker/geo/reference_system.h"
#include "baker/import/shared/up_axis.h"
#include "base/result.h"

namespace zc {

// What the caller says of an input. In this order: scale, up, offset; then from `crs` to the world's.
struct Placement {
  double scale = 1;                // metres that one unit of the file is
  std::optional<UpAxis> up;        // else as the format has it
  glm::dvec3 offset_m{0};          // in the input's reference system
  std::optional<std::string> crs;  // instead of the file's own; empty: it has none
};

class WorldPlacement {
 public:
  // For all that follows, until the next one.
  void enter_input(const Placement& asked) { asked_ = asked; }
  // A file of the input. up: of its format, whose importer has turned it to z up.
  Status enter_file(UpAxis up, const std::string& path);
  // The system that the file names; an empty name has no effect, nor has any when the caller gave one. Fails when there
  // is no way from it to the world's.
  Status set_crs(const std::string& of_file, const std::string& path);
  // How often files, or the caller, named one.
  [[nodiscard]] std::uint64_t crs_named() const { return crs_named_; }
  // The world's, by name.
  [[nodiscard]] const std::string& crs() const { return world_.name(); }
  // Whether to_world() changes points.
  [[nodiscard]] bool moves() const { return moves_ || converts_ || from_degrees(); }
  // Whether the points of this file come from another system than the world's.
  [[nodiscard]] bool converts() const { return converts_; }
  // Whether they are in no metres.
  [[nodiscard]] bool is_of_degrees() const { return !source_.is_metric(); }

  // The local frame that all inputs without metres share; the first one chooses its place.
  const EarthFrame& earth(const Geodetic& place);

  // For importers that cut polygons into triangles: of a file in degrees, a point in the local frame, which to_world()
  // then expects of this file; of any other file, the point itself. Fails where the point is not on the earth.
  Result<glm::dvec3> to_metric(const glm::dvec3& point, const std::string& path);
  // Points without a place in the world become NaN.
  Status to_world(std::vector<glm::dvec3>& points, const std::string& path);

 private:
  [[nodiscard]] bool from_degrees() const { return !source_.is_metric() && !gives_metric_; }
  // Looked up once for all files that name it: opening PROJ's database takes milliseconds.
  const ReferenceSystem& system_of(const std::string& name);
  Status enter_system(const ReferenceSystem& system, const std::string& path);
  Result<glm::dvec3> to_earth_frame(const glm::dvec3& point, const std::string& path);

  Placement asked_;
  std::map<std::string, ReferenceSystem> systems_;  // by name
  glm::dmat3 turn_{1};                              // and scale
  bool moves_ = false;
  ReferenceSystem source_;     // that the file's points are in
  ReferenceSystem metric_;     // the same, or the local frame
  bool gives_metric_ = false;  // the importer asks to_metric()
  ReferenceSystem world_;
  bool converts_ = false;  // from metric_ to world_
  std::optional<EarthFrame> earth_;
  std::uint64_t crs_named_ = 0;
};

}  // namespace zc
