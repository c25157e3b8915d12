// SPDX-License-Identifier: Apache-2.0
// Gathers the pixels whose surface mirrors; nothing later runs for the others. Those of a tile of 8×8 pixels stay
// together, wherever the list's tiles come from: packets of rays are as coherent as that. On a CPU an invocation takes
// a tile; on a GPU a workgroup does, with a thread a pixel.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "passes/bindings.glsl"
#include "adapter/load_surface.glsl"
#include "adapter/sky.glsl"
#include "shading/shading.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

const uint kTile = 8u;

shared uint tile_found[2];  // bit per pixel: rows 0 to 3, then 4 to 7
shared uint tile_at;

bool mirrors(ivec2 pixel) {
  const Surface s = load_surface(pixel);
  if (s.sky) return false;
  const Shading shading = shade_surface(s.attributes, s.shading_normal, s.view);
  return max(shading.specular.r, max(shading.specular.g, shading.specular.b)) >= 0.004;
}

void clear_pixel(ivec2 pixel) {
  provenance[uint(pixel.y) * frame.width + uint(pixel.x)] = kSourceNone;
  imageStore(reflection_image, pixel, vec4(0.0));
}

void classify_pixel() {
  const uint bit = gl_LocalInvocationIndex;
  if (bit == 0u) tile_found[0] = tile_found[1] = 0u;
  barrier();
  const uvec2 pixel = gl_GlobalInvocationID.xy;
  bool found = false;
  if (all(lessThan(pixel, frame_size()))) {
    clear_pixel(ivec2(pixel));
    found = mirrors(ivec2(pixel));
  }
  if (found) atomicOr(tile_found[bit / 32u], 1u << (bit % 32u));
  barrier();
  const uint low_count = bitCount(tile_found[0]);
  const uint count = low_count + bitCount(tile_found[1]);
  if (bit == 0u && count > 0u) tile_at = atomicAdd(counters.pixel_count, count);
  barrier();
  if (!found) return;
  const uint below = bitCount(tile_found[bit / 32u] & ((1u << (bit % 32u)) - 1u)) + (bit < 32u ? 0u : low_count);
  pixels[tile_at + below] = pixel.y * frame.width + pixel.x;
}

void classify_tile() {
  const uvec2 corner = gl_GlobalInvocationID.xy * kTile;
  const uvec2 size = min(uvec2(kTile), max(frame_size(), corner) - corner);
  uint found[2] = uint[2](0u, 0u);  // bit per pixel: rows 0 to 3, then 4 to 7
  for (uint y = 0u; y < size.y; ++y) {
    for (uint x = 0u; x < size.x; ++x) {
      const uvec2 pixel = corner + uvec2(x, y);
      clear_pixel(ivec2(pixel));
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
      pixels[at++] = pixel.y * frame.width + pixel.x;
    }
  }
}

void main() {
  if (kThreadPerPixel != 0u)
    classify_pixel();
  else
    classify_tile();
}
