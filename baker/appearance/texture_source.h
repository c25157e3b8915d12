// SPDX-License-Identifier: GPL-3.0-or-later
// The textured surface of a scene, kept beside the bake for the atlases: positions before any rounding, texture
// coordinates, images. Owns what it took. Thread-safe for const use. Deterministic.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "baker/scene/lattice_mesh.h"
#include "baker/scene/scene.h"

namespace zc {

struct SourceTriangle {
  std::array<glm::dvec3, 3> p = {};  // steps from the world's anchor
  std::array<glm::vec2, 3> uv = {};
  std::uint16_t material = 0;
};

class TextureSource {
 public:
  // Takes images and texture coordinates out of the scene.
  explicit TextureSource(Scene& scene);

  // Once, before within(): from CRS metres to steps. anchor: steps.
  void move_to_lattice(const std::array<std::int64_t, 3>& anchor, std::int32_t step_log2);

  [[nodiscard]] bool empty() const { return triangles_.empty(); }
  // Those whose boxes meet `box`, in steps; in a fixed order.
  [[nodiscard]] std::vector<const SourceTriangle*> within(const glm::dvec3& min, const glm::dvec3& max) const;
  [[nodiscard]] const TextureImage& image(std::uint32_t index) const { return images_[index]; }

 private:
  struct Block {
    glm::dvec3 min;
    glm::dvec3 max;
  };
  std::vector<SourceTriangle> triangles_;  // in Morton order once on the lattice
  std::vector<Block> blocks_;              // of kBlockTriangles each
  std::vector<TextureImage> images_;
};

}  // namespace zc
