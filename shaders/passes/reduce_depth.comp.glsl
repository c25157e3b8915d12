// SPDX-License-Identifier: Apache-2.0
// Hi-Z pyramid: each cell keeps the nearest depth (the largest, Z is reversed) of the pixels it covers. Level sizes are
// rounded up, so that cell = pixel >> level holds at every odd size. pass_constants.a = level to write.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "passes/bindings.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

void main() {
  const uvec2 cell = gl_GlobalInvocationID.xy;
  const uint level = pass_constants.a;
  const HizLevel to = frame.hiz_levels[level];
  if (cell.x >= to.width || cell.y >= to.height) return;
  float nearest = 0.0;
  if (level == 0u) {
    nearest = texelFetch(depth_image, ivec2(cell), 0).x;
  } else {
    const HizLevel from = frame.hiz_levels[level - 1u];
    const uvec2 last = uvec2(from.width, from.height) - 1u;
    const uvec2 low = min(cell * 2u, last);
    const uvec2 high = min(cell * 2u + 1u, last);
    nearest = max(max(hiz[from.first + low.y * from.width + low.x], hiz[from.first + low.y * from.width + high.x]),
                  max(hiz[from.first + high.y * from.width + low.x], hiz[from.first + high.y * from.width + high.x]));
  }
  hiz[to.first + cell.y * to.width + cell.x] = nearest;
}
