// SPDX-License-Identifier: Apache-2.0
// Gathers the pixels whose surface mirrors; nothing later runs for the others.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "bindings.glsl"
#include "surface.glsl"
#include "shading.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

void main() {
  const ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, ivec2(frame.size.xy)))) return;
  const uint index = uint(pixel.y) * frame.size.x + uint(pixel.x);
  provenance[index] = kSourceNone;
  const Surface s = load_surface(pixel);
  if (s.sky) return;
  const Shading shading = shade_surface(materials[s.material], s.normal, s.view, 1.0);
  if (max(shading.specular.r, max(shading.specular.g, shading.specular.b)) < 0.004) return;
  pixels[atomicAdd(counters.pixel_count, 1u)] = index;
}
