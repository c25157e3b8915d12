// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/repair/snap.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace zc {
namespace {

// Every integer below this is a double.
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

Error beyond_lattice(double p) {
  return {ErrorCode::kFormat, "a coordinate of " + std::to_string(p) + " m is beyond the lattice"};
}

}  // namespace

Result<WorldLattice> fit_lattice(const Scene& scene, std::int32_t step_log2) {
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
        if (!(std::abs(p[axis]) * steps_per_m < kExactLimit)) return beyond_lattice(p[axis]);
        low[axis] = std::min(low[axis], p[axis]);
        high[axis] = std::max(high[axis], p[axis]);
      }
    }
  }
  WorldLattice lattice;
  lattice.step_log2 = step_log2;
  for (int axis = 0; axis < 3; ++axis) {
    const double metres = std::floor(low[axis]);
    lattice.anchor[static_cast<std::size_t>(axis)] = static_cast<std::int64_t>(metres * steps_per_m);
    if ((high[axis] - metres) * steps_per_m >= static_cast<double>(kLatticeExtentMax - 1)) {
      return Error{ErrorCode::kUnsupported,
                   "the scene is " + std::to_string(high[axis] - low[axis]) + " m wide along " + "xyz"[axis] +
                       ", wider than the lattice at steps of 2^" + std::to_string(step_log2) + " m"};
    }
  }
  return lattice;
}

Result<SnappedScene> snap_scene(SnapInput&& input, BakeContext& context) {
  context.begin(BakeStage::kSnap);
  Scene& scene = input.scene;
  ZC_TRY(check_references(scene));
  SnappedScene out;
  out.lattice = input.lattice;
  const double steps_per_m = std::ldexp(1.0, -out.lattice.step_log2);
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
      if (!(std::abs(p) * steps_per_m < kExactLimit)) return beyond_lattice(p);
      const std::int64_t steps = std::llround(p * steps_per_m) - out.lattice.anchor[axis];
      if (steps < 0 || steps >= kLatticeExtentMax) return beyond_lattice(p);
      out.mesh.vertices[i][axis] = static_cast<std::int32_t>(steps);
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
