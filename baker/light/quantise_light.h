// SPDX-License-Identifier: GPL-3.0-or-later
// Takes differences out of a zone's light that are below its noise: the sky that corners see comes in few steps, and
// any other value that is next to its neighbour's becomes the same, which costs next to nothing on the disk. Nothing
// moves by more than one 48th of the sky, a 31st of a colour, a 63rd of the share, a 64th of the variation or a step of
// the direction. Deterministic. Thread-safe: no state.
#pragma once

#include <span>

#include "streamer/world_format/bvh_page.h"

namespace zc {

// Per triangle of `mesh`.
void quantise_light(const ZoneMesh& mesh, std::span<gpu::TriangleLight> light);

}  // namespace zc
