// SPDX-License-Identifier: Apache-2.0
// Gathers the pixels whose surface mirrors; nothing later runs for the others. An invocation takes a tile of 8×8
// pixels, so that those of a tile stay together, wherever the list's tiles come from: packets of rays are as coherent
// as that.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "passes/bindings.glsl"
#include "shading/surface.glsl"
#include "shading/shading.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

const uint kTile = 8u;

bool mirrors(ivec2 pixel) {
  const Surface s = load_surface(pixel);
  if (s.sky) return false;
  const Shading shading = shade_surface(s.attributes, s.shading_normal, s.view);
  return max(shading.specular.r, max(shading.specular.g, shading.specular.b)) >= 0.004;
}

void main() {
  const uvec2 corner = gl_GlobalInvocationID.xy * kTile;
  const uvec2 size = min(uvec2(kTile), max(frame.size.xy, corner) - corner);
  uint found[2] = uint[2](0u, 0u);  // bit per pixel: rows 0 to 3, then 4 to 7
  for (uint y = 0u; y < size.y; ++y) {
    for (uint x = 0u; x < size.x; ++x) {
      const uvec2 pixel = corner + uvec2(x, y);
      provenance[pixel.y * frame.size.x + pixel.x] = kSourceNone;
      if (mirrors(ivec2(pixel))) found[y / 4u] |= 1u << (kTile * (y % 4u) + x);
    }
  }
  const uint count = bitCount(found[0]) + bitCount(found[1]);
  if (count == 0u) return;
  uint at = atomicAdd(counters.pixel_count, count);
  for (uint half_tile = 0u; half_tile < 2u; ++half_tile) {
    for (uint left = found[half_tile]; left != 0u; left &= left - 1u) {
      const uint bit = uint(findLSB(left));
      const uvec2 pixel = corner + uvec2(bit % kTile, 4u * half_tile + bit / kTile);
      pixels[at++] = pixel.y * frame.size.x + pixel.x;
    }
  }
}
