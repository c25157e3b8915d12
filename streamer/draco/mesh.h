// SPDX-License-Identifier: Apache-2.0
// Decodes the triangles and positions of a Draco mesh stream, in the order in which draco gives them, in memory that
// the stream's layout gives before: about 16 bytes a triangle and 4 a position beyond what comes out.
// Borrows everything. Untrusted input: a damaged stream is refused, or gives triangles of its own vertices.
// Thread-safe: no state.
// Source: Draco bitstream 2.2, "Prediction Decoder", "Prediction Parallelogram Decoder", "Prediction Multi
// Parallelogram Decoder", "Prediction Wrap Transform"; draco 1.5.5 for sequential indices.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "streamer/draco/layout.h"

namespace zc {

// `vertices` and `triangles` are as many as the layout says, zeroed; the triangles' vertices are numbered from 0.
// `words`: layout.scratch_words() of them. False for a damaged stream.
bool decode_draco(const DracoLayout& layout, std::span<std::array<std::uint16_t, 3>> vertices,
                  std::span<std::array<std::uint32_t, 3>> triangles, std::span<std::uint32_t> words);

}  // namespace zc
