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
  // Takes images and texture coordinates out of the scene, whose references fit_lattice has checked.
  TextureSource(Scene& scene, const WorldLattice& lattice);

  [[nodiscard]] bool empty() const { return triangles_.empty(); }
  // Those whose boxes intersect this one, in steps; in a fixed order.
  [[nodiscard]] std::vector<const SourceTriangle*> within(const glm::dvec3& min, const glm::dvec3& max) const;
  [[nodiscard]] const TextureImage& image(std::uint32_t index) const { return images_[index]; }

 private:
  struct Block {
    glm::dvec3 min;
    glm::dvec3 max;
  };
  void sort();

  std::vector<SourceTriangle> triangles_;  // in Morton order
  std::vector<Block> blocks_;              // of kBlockTriangles each
  std::vector<TextureImage> images_;
};

}  // namespace zc
