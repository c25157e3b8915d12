// SPDX-License-Identifier: GPL-3.0-or-later
// Collects whole objects into a Scene: welds equal positions within an object, drops triangles that cannot be used,
// shares equal materials, counts what was left out. The order of calls alone decides the result.
// Owns the growing scene. Not thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "baker/import/shared/material_rules.h"
#include "baker/import/shared/world_placement.h"
#include "baker/scene/scene.h"
#include "base/result.h"

namespace zc {

struct ObjectMesh {
  std::string id;
  std::string type = {};                  // of a city object: "Building"
  ObjectKind kind = ObjectKind::kObject;  // kObject becomes kGround when the object is too wide for one zone
  std::vector<glm::dvec3> positions;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint16_t> materials;      // per triangle
  std::vector<TriangleTexcoords> texcoords;  // ascending; of some triangles
};

// Wider than this in x or y, an object is ground: it is cut along zone borders.
inline constexpr double kGroundExtentM = 128;
// Beyond this a coordinate has no place on any lattice.
inline constexpr double kMaxCoordinateM = 1.8e18;
// Beyond this a texture coordinate, a float, separates not even whole repeats of the image.
inline constexpr float kMaxTexcoord = 1U << 24U;
// That instances may show together, each of their objects counted as one at least: a small file can place a model a
// million times.
inline constexpr std::uint64_t kMaxInstancedTriangles = 1U << 22U;

class SceneBuilder {
 public:
  explicit SceneBuilder(MaterialRules rules = {}) : rules_(std::move(rules)) {}

  // Index of an equal material, added when new. A full table yields the nearest in colour and roughness that has no
  // texture.
  std::uint16_t material(const Material& material);
  // Indices in `mesh` must be in range. An object without a usable triangle is left out.
  Status add(const ObjectMesh& mesh);
  // Every object that is added next appears once at each of these places, its positions transformed; none: as it is.
  // All places of all objects together may show so many triangles; add() fails beyond.
  void set_instances(std::vector<glm::dmat4> places) { instances_ = std::move(places); }
  // What is noted next lies in this file, outside any object.
  void enter_file(const std::string& path) { place_ = {path, {}}; }
  void enter_object(const std::string& id) { place_.object = id; }
  // A square of dry land under all that was added, a little wider. z_m: its height; else that of the lowest point.
  Status add_ground_plane(std::optional<double> z_m);
  void note(const std::string& what, std::uint64_t count = 1);
  // The same of what takes nothing from the city.
  void remark(const std::string& what, std::uint64_t count = 1);
  // One for each of the files that are named.
  void note_files(const std::string& what, const std::vector<std::string>& names);
  // Parts of the input that are not there, so that it is not whole; the first few by name.
  void note_missing(const std::string& what, std::uint64_t count, std::vector<std::string> first_names);
  // The system that a file names.
  Status set_crs(const std::string& crs, const std::string& path);
  [[nodiscard]] WorldPlacement& placement() { return placement_; }
  [[nodiscard]] Scene finish(std::vector<TextureImage> images);

 private:
  using TextureKey = std::array<float, 9>;
  using MaterialKey = std::tuple<std::string, std::string, float, float, float, float, float, TextureKey>;
  struct Place {
    std::string file;
    std::string object;
  };
  Status add_once(const ObjectMesh& mesh);

  const MaterialRules rules_;
  Scene scene_;
  Place place_;
  std::vector<glm::dmat4> instances_;
  std::uint64_t instanced_triangles_ = 0;
  WorldPlacement placement_;
  std::map<MaterialKey, std::uint16_t> materials_;
  std::map<std::string, std::size_t> notes_;
};

}  // namespace zc
