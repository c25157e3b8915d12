// SPDX-License-Identifier: GPL-3.0-or-later
// Positions and triangles of one glTF primitive: plain, sparse or quantised accessors, strips and fans, or Draco.
// Untrusted input: every range is checked before it is read. Thread-safe: no state.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "baker/import/gltf/gltf_budget.h"
#include "baker/import/gltf/gltf_file.h"

namespace zc {

struct GltfGeometry {
  std::vector<glm::dvec3> positions;  // in the mesh's own frame
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<glm::vec2> texcoords;  // per position; empty: none
  std::vector<glm::vec3> colors;     // COLOR_0, linear, likewise
  std::uint32_t loose_corners = 0;   // of a list, behind its last whole triangle
};

// Empty for primitives of points or lines; without positions that no triangle uses where those are the most. texcoord:
// which TEXCOORD_ is read where there is one; negative: none. `where` names the primitive in errors.
Result<GltfGeometry> read_primitive(const GltfFile& file, const tinygltf::Primitive& primitive, int texcoord,
                                    const std::string& where, GltfBudget& budget);

// Numbers of an accessor, components of an element after each other; normalised ones as KHR_mesh_quantization defines.
Result<std::vector<double>> read_accessor(const GltfFile& file, int index, int wanted_type, std::size_t components,
                                          const std::string& where, GltfBudget& budget);

// The KHR_draco_mesh_compression extension of a primitive that has it.
Result<GltfGeometry> read_draco_primitive(const GltfFile& file, const tinygltf::Primitive& primitive, int texcoord,
                                          const std::string& where);

// A stored integer component as KHR_mesh_quantization defines it: normalised types map to [-1, 1] or [0, 1].
double dequantised(double stored, int component_type, bool normalized);

}  // namespace zc
