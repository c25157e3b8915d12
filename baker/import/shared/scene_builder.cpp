// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/shared/scene_builder.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <unordered_map>

#include "baker/import/shared/surface_material.h"
#include "base/check.h"
#include "base/text.h"

namespace zc {
namespace {

constexpr std::size_t kMaxMaterials = 65'535;
constexpr std::size_t kMaxCrsNameBytes = 16U << 10U;  // of WKT; a world's index has room for more

struct PositionHash {
  std::size_t operator()(const glm::dvec3& p) const {
    std::uint64_t hash = 0x9E3779B97F4A7C15ULL;
    for (const double value : {p.x, p.y, p.z}) {
      hash = (hash ^ std::bit_cast<std::uint64_t>(value)) * 0xFF51AFD7ED558CCDULL;
      hash ^= hash >> 32U;
    }
    return hash;
  }
};

bool usable(const glm::dvec3& p) {
  // Written so that NaN fails too.
  return std::abs(p.x) <= kMaxCoordinateM && std::abs(p.y) <= kMaxCoordinateM && std::abs(p.z) <= kMaxCoordinateM;
}

// Whether the coordinates separate texels; false for NaN.
bool usable(const TriangleTexcoords& texcoords) {
  return std::all_of(texcoords.uv.begin(), texcoords.uv.end(), [](const glm::vec2& uv) {
    return std::abs(uv.x) <= kMaxTexcoord && std::abs(uv.y) <= kMaxTexcoord;
  });
}

}  // namespace

std::uint16_t SceneBuilder::material(const Material& material) {
  TextureKey texture{-1};
  if (const auto& t = material.texture)
    texture = {static_cast<float>(t->image),  // below 2^24: every image has texels
               static_cast<float>(t->wrap_u),
               static_cast<float>(t->wrap_v),
               t->factor.x,
               t->factor.y,
               t->factor.z,
               t->offset.x,
               t->offset.y,
               t->offset.z};
  const MaterialKey key{material.name,         material.surface,   material.base_color.x, material.base_color.y,
                        material.base_color.z, material.roughness, material.metallic,     texture};
  if (const auto known = materials_.find(key); known != materials_.end()) return known->second;
  if (scene_.materials.size() < kMaxMaterials) {
    const auto index = static_cast<std::uint16_t>(scene_.materials.size());
    scene_.materials.push_back(material);
    materials_.emplace(key, index);
    return index;
  }
  note("materials beyond 65535, replaced by the nearest");
  const auto distance = [&](const Material& other) {
    const glm::vec3 d = other.base_color - material.base_color;
    const float r = other.roughness - material.roughness;
    const float m = other.metallic - material.metallic;
    return glm::dot(d, d) + r * r + m * m + (other.texture ? 100.0F : 0.0F);
  };
  const auto nearest = std::min_element(scene_.materials.begin(), scene_.materials.end(),
                                        [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
  return static_cast<std::uint16_t>(nearest - scene_.materials.begin());
}

Status SceneBuilder::add(const ObjectMesh& mesh) {
  if (instances_.empty()) return add_once(mesh);
  const std::uint64_t triangles = std::max<std::uint64_t>(mesh.triangles.size(), 1);
  if (instances_.size() > (kMaxInstancedTriangles - instanced_triangles_) / triangles)
    return Error{ErrorCode::kUnsupported,
                 "object '" + printable(mesh.id, 80) + "' of " + std::to_string(mesh.triangles.size()) +
                     " triangles stands at " + std::to_string(instances_.size()) +
                     " places: all instances of a bake may have " + std::to_string(kMaxInstancedTriangles) +
                     " triangles; bake fewer tiles at once or leave out the instanced ones"};
  instanced_triangles_ += triangles * instances_.size();
  ObjectMesh instance = mesh;
  for (std::size_t i = 0; i < instances_.size(); ++i) {
    const glm::dmat4& place = instances_[i];
    instance.id = mesh.id + "_" + std::to_string(i);
    for (std::size_t p = 0; p < mesh.positions.size(); ++p)
      instance.positions[p] = glm::dvec3(place * glm::dvec4(mesh.positions[p], 1));
    const bool mirrored = glm::determinant(glm::dmat3(place)) < 0;
    for (std::size_t t = 0; mirrored && t < mesh.triangles.size(); ++t)
      instance.triangles[t] = {mesh.triangles[t][0], mesh.triangles[t][2], mesh.triangles[t][1]};
    if (!mirrored) instance.triangles = mesh.triangles;
    for (std::size_t t = 0; t < mesh.texcoords.size(); ++t) {
      const auto& [a, b, c] = mesh.texcoords[t].uv;
      instance.texcoords[t].uv = mirrored ? std::array{a, c, b} : std::array{a, b, c};
    }
    ZC_TRY(add_once(instance));
  }
  return {};
}

Status SceneBuilder::add_once(const ObjectMesh& mesh) {
  ZC_CHECK(mesh.triangles.size() == mesh.materials.size());
  enter_object(mesh.id);
  std::vector<glm::dvec3> moved;
  if (placement_.moves()) {
    moved = mesh.positions;
    ZC_TRY(placement_.to_world(moved, place_.file));
  }
  const std::vector<glm::dvec3>& positions = moved.empty() ? mesh.positions : moved;
  const std::size_t first = scene_.triangles.size();
  // Looked up only, never walked: the order of vertices is the order of first use.
  std::unordered_map<glm::dvec3, std::uint32_t, PositionHash> welded;
  welded.reserve(std::min(mesh.positions.size(), 3 * mesh.triangles.size()));
  glm::dvec3 low(std::numeric_limits<double>::max());
  glm::dvec3 high(std::numeric_limits<double>::lowest());
  auto texcoords = mesh.texcoords.begin();
  std::map<std::uint16_t, std::uint16_t> ruled;  // what the rules make of this object's materials
  const auto material_of = [&](std::uint16_t index) {
    if (rules_.empty()) return index;
    const auto [slot, is_new] = ruled.try_emplace(index);
    if (is_new) slot->second = material(rules_.apply(scene_.materials[index], mesh.type, mesh.id, mesh.kind));
    return slot->second;
  };
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    while (texcoords != mesh.texcoords.end() && texcoords->triangle < t) ++texcoords;
    std::array<glm::dvec3, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      ZC_CHECK(mesh.triangles[t][k] < mesh.positions.size());
      corners[k] = positions[mesh.triangles[t][k]] + 0.0;  // + 0.0 turns -0 into 0, so that both weld
    }
    if (!usable(corners[0]) || !usable(corners[1]) || !usable(corners[2])) {
      note("triangles with coordinates that are not finite or out of range, dropped");
      continue;
    }
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) {
      remark("triangles with coinciding corners, dropped");
      continue;
    }
    if (scene_.positions.size() >= std::numeric_limits<std::uint32_t>::max() - 3 ||
        scene_.triangles.size() >= std::numeric_limits<std::uint32_t>::max() - 1)
      return Error{ErrorCode::kUnsupported, "the scene has more than 2^32 vertices or triangles"};
    std::array<std::uint32_t, 3> triangle{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [slot, is_new] = welded.try_emplace(corners[k], static_cast<std::uint32_t>(scene_.positions.size()));
      if (is_new) scene_.positions.push_back(corners[k]);
      triangle[k] = slot->second;
      low = glm::min(low, corners[k]);
      high = glm::max(high, corners[k]);
    }
    const std::uint16_t material_index = material_of(mesh.materials[t]);
    if (texcoords != mesh.texcoords.end() && texcoords->triangle == t && scene_.materials[material_index].texture) {
      if (usable(*texcoords))
        scene_.texcoords.push_back({static_cast<std::uint32_t>(scene_.triangles.size()), texcoords->uv});
      else
        note("triangles with texture coordinates that are not finite or beyond 2^24, mean colour used");
    }
    scene_.triangles.push_back(triangle);
    scene_.triangle_material.push_back(material_index);
  }
  const std::size_t count = scene_.triangles.size() - first;
  if (count == 0) return {};
  const bool wide = high.x - low.x > kGroundExtentM || high.y - low.y > kGroundExtentM;
  scene_.objects.push_back({mesh.id, wide ? ObjectKind::kGround : mesh.kind, static_cast<std::uint32_t>(first),
                            static_cast<std::uint32_t>(count)});
  return {};
}

Status SceneBuilder::add_ground_plane(std::optional<double> z_m) {
  if (scene_.positions.empty()) return {};
  constexpr double kWider = 0.1;  // of its size, and as many metres
  constexpr double kWider_m = 10;
  glm::dvec3 low = scene_.positions.front();
  glm::dvec3 high = low;
  for (const glm::dvec3& p : scene_.positions) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  const glm::dvec3 more = (high - low) * kWider + kWider_m;
  const double z = z_m.value_or(low.z);
  ObjectMesh plane;
  plane.id = "ground plane";
  plane.kind = ObjectKind::kGround;
  plane.positions = {{low.x - more.x, low.y - more.y, z},
                     {high.x + more.x, low.y - more.y, z},
                     {high.x + more.x, high.y + more.y, z},
                     {low.x - more.x, high.y + more.y, z}};
  plane.triangles = {{0, 1, 2}, {0, 2, 3}};
  plane.materials.assign(2, material(surface_material(Surface::kLand, plane.type, plane.id, {})));
  enter_file({});
  return add_once(plane);
}

void SceneBuilder::note(const std::string& what, std::uint64_t count) {
  const auto [slot, is_new] = notes_.try_emplace(what, scene_.notes.size());
  if (is_new) {
    scene_.notes.push_back({what, 0});
    if (!place_.file.empty())
      scene_.notes.back().names = {place_.file + (place_.object.empty() ? "" : ": '" + place_.object + "'")};
  }
  scene_.notes[slot->second].count += count;
}

void SceneBuilder::remark(const std::string& what, std::uint64_t count) {
  note(what, count);
  scene_.notes[notes_.at(what)].is_loss = false;
}

void SceneBuilder::note_files(const std::string& what, const std::vector<std::string>& names) {
  if (!names.empty()) scene_.notes.push_back({what, names.size(), names});
}

void SceneBuilder::note_missing(const std::string& what, std::uint64_t count, std::vector<std::string> first_names) {
  if (count > 0) scene_.notes.push_back({what, count, std::move(first_names), true});
}

Status SceneBuilder::set_crs(const std::string& crs, const std::string& path) {
  if (crs.size() > kMaxCrsNameBytes)
    return Error{ErrorCode::kUnsupported,
                 "the name of its reference system takes " + std::to_string(crs.size()) + " bytes, at most " +
                     std::to_string(kMaxCrsNameBytes) + " are read",
                 path};
  if (lower(crs).find("epsg") != std::string::npos && (crs.back() < '0' || crs.back() > '9'))
    remark("reference systems without an EPSG code at their end, kept as they are written");
  return placement_.set_crs(crs, path);
}

Scene SceneBuilder::finish(std::vector<TextureImage> images) {
  scene_.images = std::move(images);
  scene_.crs = placement_.crs();
  return std::move(scene_);
}

}  // namespace zc
