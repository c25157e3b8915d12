// SPDX-License-Identifier: GPL-3.0-or-later
// Points and rings of GML, and where they lie in the world: metres in the model's reference system or, where that is
// geographic, in a local frame, z up. Borrows the document, the frame and the builder. Untrusted input. Not
// thread-safe. Source: OGC 03-105r1 (GML 3.1.1), OGC 07-036 (GML 3.2.1).
#pragma once

#include <glm/vec3.hpp>
#include <pugixml.hpp>
#include <string>
#include <vector>

#include "baker/import/shared/scene_builder.h"
#include "base/result.h"

namespace zc {

struct GmlRing {
  pugi::xml_node node;             // the LinearRing
  std::vector<glm::dvec3> points;  // as they are written
};

class GmlGeometry {
 public:
  GmlGeometry(const std::string& path, SceneBuilder& builder) : path_(path), builder_(builder) {}

  // The system of all that follows.
  Status enter_model(const pugi::xml_node& model);
  // Of a ring or of a Point: a posList, pos one by one, or the older coordinates.
  [[nodiscard]] Result<std::vector<glm::dvec3>> points_of(const pugi::xml_node& ring) const;
  // The exterior of a polygon, then its interiors.
  [[nodiscard]] Result<std::vector<GmlRing>> rings_of(const pugi::xml_node& polygon) const;
  // `node` is named where the point lies nowhere.
  Result<glm::dvec3> to_metric(const glm::dvec3& point, const pugi::xml_node& node);

 private:
  const std::string& path_;
  SceneBuilder& builder_;
};

}  // namespace zc
