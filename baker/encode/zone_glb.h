// SPDX-License-Identifier: GPL-3.0-or-later
// Writes a proxy as a zone .glb: one Draco-compressed primitive, 16-bit lattice positions without loss
// (KHR_draco_mesh_compression, KHR_mesh_quantization), colours for viewers. node.matrix takes the positions to metres
// relative to the world's anchor, y up. Which material a triangle has is not in it but in the .zbvh. Every stream is
// decoded again: the triangles must come back exactly.
// Deterministic. Thread-safe: no state.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "baker/scene/lattice_mesh.h"
#include "baker/scene/scene.h"
#include "base/result.h"

namespace zc {

struct EncodedZone {
  std::vector<std::byte> glb;
  std::uint64_t draco_bytes = 0;  // of the .glb; the rest is JSON and frame
  LatticePoint origin = {};
  LatticePoint bounds_min = {};
  LatticePoint bounds_max = {};
  std::uint32_t triangle_count = 0;
  std::uint32_t vertex_count = 0;  // Draco's points, over all primitives
  std::uint32_t primitive_count = 0;
  std::vector<std::uint16_t> materials;  // per triangle as decoded
};

// The mesh's vertices must be multiples of 2^step_shift and span less than 2^16 of them.
Result<EncodedZone> encode_zone_glb(const LatticeMesh& mesh, std::uint32_t step_shift,
                                    std::span<const Material> materials, double step_m);

}  // namespace zc
