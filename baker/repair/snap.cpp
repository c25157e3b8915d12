// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/repair/snap.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace zc {
namespace {

// Doubles hold every integer below this exactly.
constexpr double kExactLimit = 4503599627370496.0;  // 2^52

Status check_references(const Scene& scene) {
  if (scene.triangles.empty()) return Error{ErrorCode::kFormat, "the scene has no triangles"};
  if (scene.triangle_material.size() != scene.triangles.size())
    return Error{ErrorCode::kFormat, "the scene's triangles and materials differ in number"};
  if (scene.triangles.size() > std::numeric_limits<std::uint32_t>::max() / 3)
    return Error{ErrorCode::kUnsupported, "the scene has more than 2^32 / 3 triangles"};
  for (const auto& triangle : scene.triangles)
    for (const std::uint32_t v : triangle)
      if (v >= scene.positions.size()) return Error{ErrorCode::kFormat, "a triangle refers to a missing vertex"};
  const std::size_t material_count = std::max<std::size_t>(scene.materials.size(), 1);
  for (const std::uint16_t m : scene.triangle_material)
    if (m >= material_count) return Error{ErrorCode::kFormat, "a triangle refers to a missing material"};
  std::size_t next = 0;
  for (const auto& object : scene.objects) {
    if (object.first_triangle != next || object.triangle_count > scene.triangles.size() - next)
      return Error{ErrorCode::kFormat, "object '" + object.id + "' does not follow its predecessor's triangles"};
    next += object.triangle_count;
  }
  if (next != scene.triangles.size())
    return Error{ErrorCode::kFormat, "the scene's objects do not cover its triangles"};
  return {};
}

}  // namespace

Result<SnappedScene> snap_scene(Scene&& scene, std::int32_t step_log2) {
  if (step_log2 < -16 || step_log2 > 0)
    return Error{ErrorCode::kArgument, "the lattice step must be 2^-16 to 1 metre, got 2^" + std::to_string(step_log2)};
  ZC_TRY(check_references(scene));
  const double steps_per_m = std::ldexp(1.0, -step_log2);

  glm::dvec3 low(std::numeric_limits<double>::infinity());
  glm::dvec3 high(-std::numeric_limits<double>::infinity());
  for (const auto& triangle : scene.triangles) {
    for (const std::uint32_t v : triangle) {
      const glm::dvec3& p = scene.positions[v];
      for (int axis = 0; axis < 3; ++axis) {
        if (!(std::abs(p[axis]) * steps_per_m < kExactLimit))
          return Error{ErrorCode::kFormat, "a coordinate of " + std::to_string(p[axis]) + " m is beyond the lattice"};
        low[axis] = std::min(low[axis], p[axis]);
        high[axis] = std::max(high[axis], p[axis]);
      }
    }
  }
  SnappedScene out;
  out.step_log2 = step_log2;
  for (int axis = 0; axis < 3; ++axis) {
    const double metres = std::floor(low[axis]);
    out.anchor[static_cast<std::size_t>(axis)] = static_cast<std::int64_t>(metres * steps_per_m);
    if ((high[axis] - metres) * steps_per_m >= static_cast<double>(kLatticeExtentMax - 1)) {
      return Error{ErrorCode::kUnsupported,
                   "the scene is " + std::to_string(high[axis] - low[axis]) + " m wide along " + "xyz"[axis] +
                       ", more than the lattice holds at steps of 2^" + std::to_string(step_log2) + " m"};
    }
  }

  out.mesh.vertices.resize(scene.positions.size());
  std::vector<bool> used(scene.positions.size(), false);
  out.mesh.faces.reserve(scene.triangles.size());
  for (const auto& object : scene.objects) {
    for (std::uint32_t i = 0; i < object.triangle_count; ++i) {
      const std::uint32_t t = object.first_triangle + i;
      out.mesh.faces.push_back({scene.triangles[t], scene.triangle_material[t], object.kind == ObjectKind::kGround});
      for (const std::uint32_t v : scene.triangles[t]) used[v] = true;
    }
  }
  for (std::size_t i = 0; i < scene.positions.size(); ++i) {
    if (!used[i]) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double p = scene.positions[i][static_cast<int>(axis)];
      out.mesh.vertices[i][axis] = static_cast<std::int32_t>(std::llround(p * steps_per_m) - out.anchor[axis]);
    }
  }
  weld(out.mesh);

  std::erase_if(scene.objects, [](const SceneObject& object) { return object.triangle_count == 0; });
  out.objects = std::move(scene.objects);
  out.materials = std::move(scene.materials);
  if (out.materials.empty()) out.materials.emplace_back();
  out.crs = std::move(scene.crs);
  out.notes = std::move(scene.notes);
  return out;
}

}  // namespace zc
