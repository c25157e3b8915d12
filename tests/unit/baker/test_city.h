// SPDX-License-Identifier: GPL-3.0-or-later
// Small deterministic scenes for the baker's tests.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <string>

#include "baker/scene/scene.h"

namespace zc::test {

class SceneMaker {
 public:
  SceneMaker() {
    scene.materials = {{"wall", {0.6F, 0.5F, 0.4F}, 0.9F, 0},
                       {"roof", {0.5F, 0.2F, 0.1F}, 0.8F, 0},
                       {"grass", {0.1F, 0.4F, 0.1F}, 1.0F, 0},
                       {"road", {0.1F, 0.1F, 0.1F}, 0.3F, 0}};
  }

  void triangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, std::uint16_t material) {
    const auto base = static_cast<std::uint32_t>(scene.positions.size());
    scene.positions.insert(scene.positions.end(), {a, b, c});
    scene.triangles.push_back({base, base + 1, base + 2});
    scene.triangle_material.push_back(material);
  }
  void quad(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d,
            std::uint16_t material) {
    triangle(a, b, c, material);
    triangle(a, c, d, material);
  }
  void box(const glm::dvec3& low, const glm::dvec3& high) {
    const auto at = [&](int x, int y, int z) {
      return glm::dvec3(x ? high.x : low.x, y ? high.y : low.y, z ? high.z : low.z);
    };
    quad(at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1), 0);
    quad(at(1, 0, 0), at(1, 1, 0), at(1, 1, 1), at(1, 0, 1), 0);
    quad(at(1, 1, 0), at(0, 1, 0), at(0, 1, 1), at(1, 1, 1), 0);
    quad(at(0, 1, 0), at(0, 0, 0), at(0, 0, 1), at(0, 1, 1), 0);
    quad(at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1), 1);
  }
  // Closes an object over the triangles since the last one.
  void object(ObjectKind kind) {
    SceneObject out;
    out.id = std::to_string(scene.objects.size());
    out.kind = kind;
    out.first_triangle = closed_;
    out.triangle_count = static_cast<std::uint32_t>(scene.triangles.size()) - closed_;
    closed_ += out.triangle_count;
    scene.objects.push_back(out);
  }
  // Rolling ground of cells × cells quads with a road on every eighth row.
  void terrain(const glm::dvec3& corner, int cells, double cell_m) {
    const auto at = [&](int x, int y) {
      return corner + glm::dvec3(x * cell_m, y * cell_m, 2.0 * std::sin(x * 0.31) * std::cos(y * 0.23));
    };
    for (int y = 0; y < cells; ++y)
      for (int x = 0; x < cells; ++x) quad(at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1), y % 8 == 0 ? 3 : 2);
    object(ObjectKind::kGround);
  }
  // Boxes in a regular grid, of different heights.
  void houses(const glm::dvec3& corner, int count, double pitch_m) {
    for (int y = 0; y < count; ++y) {
      for (int x = 0; x < count; ++x) {
        const glm::dvec3 low = corner + glm::dvec3(x * pitch_m + 3.1, y * pitch_m + 2.7, -1);
        box(low, low + glm::dvec3(pitch_m * 0.5, pitch_m * 0.6, 6 + (x * 7 + y * 13) % 17));
        object(ObjectKind::kObject);
      }
    }
  }

  Scene scene;

 private:
  std::uint32_t closed_ = 0;
};

inline Scene small_city(const glm::dvec3& corner = {0, 0, 0}) {
  SceneMaker maker;
  maker.terrain(corner, 40, 7.3);
  maker.houses(corner, 12, 23.3);
  return std::move(maker.scene);
}

}  // namespace zc::test
