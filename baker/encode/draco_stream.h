// SPDX-License-Identifier: GPL-3.0-or-later
// One triangle list as a Draco stream: edgebreaker connectivity, 16-bit positions, lossless; colours of triangles at
// their corners, so that viewers show them. Thread-safe: no state.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/result.h"

namespace zc {

using Rgb8 = std::array<std::uint8_t, 3>;

struct QuantizedTriangles {
  std::vector<std::array<std::uint16_t, 3>> vertices;  // no two alike
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<Rgb8> colors;  // per triangle, or empty
};

struct DracoStream {
  std::vector<std::byte> bytes;
  std::uint32_t position_id = 0;
  std::uint32_t color_id = 0;     // with colours
  std::uint32_t point_count = 0;  // as decoded: non-manifold vertices and those between colours are split
  std::array<std::uint16_t, 3> min = {};
  std::array<std::uint16_t, 3> max = {};
  std::vector<std::uint32_t> order;  // for each triangle as decoded, which it is of the mesh
};

// Falls back to sequential connectivity where edgebreaker does not give the same triangles back, or not in a stream
// that the streamer reads; not with colours. Fails when nothing does.
Result<DracoStream> encode_draco(const QuantizedTriangles& mesh);

}  // namespace zc
