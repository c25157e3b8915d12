// SPDX-License-Identifier: GPL-3.0-or-later
// Binned SAH BVH over a zone's decoded mesh, in 16-bit lattice units, so that boxes bound the vertices exactly.
// Source: Wald 2007, "On fast construction of SAH-based bounding volume hierarchies".
// Leaves hold at most four triangles; depth never exceeds gpu::kPageMaxDepth. Deterministic. Thread-safe: no state.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "base/result.h"
#include "streamer/world_format/bvh_page.h"

namespace zc {

// Fails when there is no triangle, or more than a page can number.
Result<BvhFile> build_bvh(std::span<const std::array<std::uint16_t, 3>> vertices,
                          std::span<const std::array<std::uint32_t, 3>> triangles);

}  // namespace zc
