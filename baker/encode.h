// SPDX-License-Identifier: GPL-3.0-or-later
// Writes a proxy as a zone .glb: one Draco-compressed primitive per material, 16-bit lattice positions without loss
// (KHR_draco_mesh_compression, KHR_mesh_quantization). node.matrix takes the positions to metres relative to the
// world's anchor, y up. Every stream is decoded again: the triangles must come back exactly.
// Deterministic. Thread-safe: no state.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "baker/lattice_mesh.h"
#include "baker/scene.h"
#include "base/result.h"

namespace zc {

struct EncodedZone {
  std::vector<std::byte> glb;
  LatticePoint origin = {};
  LatticePoint bounds_min = {};
  LatticePoint bounds_max = {};
  std::uint32_t triangle_count = 0;
  std::uint32_t vertex_count = 0;  // as decoded, over all primitives
  std::uint32_t primitive_count = 0;
};

// The mesh's vertices must be multiples of 2^step_shift and span less than 2^16 of them.
Result<EncodedZone> encode_zone_glb(const LatticeMesh& mesh, std::uint32_t step_shift,
                                    std::span<const Material> materials, double step_m);

}  // namespace zc
