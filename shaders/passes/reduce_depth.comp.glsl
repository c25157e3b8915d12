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
  const uvec4 to = frame.hiz_offset[level];
  if (cell.x >= to.y || cell.y >= to.z) return;
  float nearest = 0.0;
  if (level == 0u) {
    nearest = texelFetch(depth_image, ivec2(cell), 0).x;
  } else {
    const uvec4 from = frame.hiz_offset[level - 1u];
    const uvec2 last = from.yz - 1u;
    const uvec2 low = min(cell * 2u, last);
    const uvec2 high = min(cell * 2u + 1u, last);
    nearest = max(max(hiz[from.x + low.y * from.y + low.x], hiz[from.x + low.y * from.y + high.x]),
                  max(hiz[from.x + high.y * from.y + low.x], hiz[from.x + high.y * from.y + high.x]));
  }
  hiz[to.x + cell.y * to.y + cell.x] = nearest;
}
