// SPDX-License-Identifier: GPL-3.0-or-later
// One triangle list as a Draco stream: edgebreaker connectivity, 16-bit positions, lossless. Thread-safe: no state.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/result.h"

namespace zc {

struct QuantizedTriangles {
  std::vector<std::array<std::uint16_t, 3>> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

struct DracoStream {
  std::vector<std::byte> bytes;
  std::uint32_t attribute_id = 0;
  std::uint32_t vertex_count = 0;  // as decoded: non-manifold vertices are split
  std::array<std::uint16_t, 3> min = {};
  std::array<std::uint16_t, 3> max = {};
};

// Falls back to sequential connectivity where edgebreaker does not give the same triangles back.
Result<DracoStream> encode_draco(const QuantizedTriangles& mesh);

}  // namespace zc
