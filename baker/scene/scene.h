// SPDX-License-Identifier: GPL-3.0-or-later
// What every importer yields and the cut consumes: a triangle soup of whole objects in CRS metres, z up.
// Thread-safe: plain values.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "baker/scene/texture_image.h"

namespace zc {

// Base colour by place: offset + factor * the image's texel, linear.
struct SurfaceTexture {
  std::uint32_t image = 0;  // of Scene::images
  TextureWrap wrap_u = TextureWrap::kRepeat;
  TextureWrap wrap_v = TextureWrap::kRepeat;
  glm::vec3 factor{1};
  glm::vec3 offset{0};

  bool operator==(const SurfaceTexture&) const = default;
};

struct Material {
  std::string name;
  glm::vec3 base_color = {0.8F, 0.8F, 0.8F};  // linear; a texture's mean
  float roughness = 0.9F;
  float metallic = 0;
  std::optional<SurfaceTexture> texture = {};
  std::string surface = {};  // semantic type that it was chosen by; empty: the input's own material

  bool operator==(const Material&) const = default;
};

// Ground (terrain, roads, water) is cut along zone borders; any other object stays whole in one zone when its extent
// allows.
enum class ObjectKind : std::uint8_t { kObject, kGround };

struct SceneObject {
  std::string id;
  ObjectKind kind = ObjectKind::kObject;
  std::uint32_t first_triangle = 0;
  std::uint32_t triangle_count = 0;
};

// What the import left out or replaced, by kind; printed once per kind, never silently dropped.
struct ImportCount {
  std::string what;
  std::uint64_t count = 0;
  std::vector<std::string> names = {};  // of the files that it befell, or the place where it did first, if known
  bool is_missing = false;              // parts of the input that are not there: the city is not whole
  bool is_loss = true;                  // or the same city, read in another way
};

// v downwards, as in glTF.
struct TriangleTexcoords {
  std::uint32_t triangle = 0;
  std::array<glm::vec2, 3> uv = {};
};

struct Scene {
  std::vector<glm::dvec3> positions;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint16_t> triangle_material;
  std::vector<SceneObject> objects;          // contiguous, in order, cover all triangles
  std::vector<TriangleTexcoords> texcoords;  // ascending; of triangles whose material has a texture
  std::vector<Material> materials;
  std::vector<TextureImage> images;
  std::string crs;
  std::vector<ImportCount> notes;
};

}  // namespace zc
