// SPDX-License-Identifier: Apache-2.0
// The top-level BVH over resident zones, rebuilt on the CPU when residency changes.
// Thread-safe: no state. Source: sweep SAH (MacDonald & Booth 1990).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "shaders/shared/scene.h"

namespace zc {

// Lattice units, inclusive.
struct ZoneBounds {
  std::array<std::int32_t, 3> min;
  std::array<std::int32_t, 3> max;
};

struct TopLevel {
  std::vector<gpu::TopNode> nodes;  // node 0 is the root, also when there is no zone
  std::uint32_t depth = 1;          // inner nodes on the longest path
};

// Leaf references are positions in `zones`. Deterministic.
TopLevel build_top_level(std::span<const ZoneBounds> zones);

}  // namespace zc
