// SPDX-License-Identifier: Apache-2.0
// What the compute passes bind; each uses a part of it.
#include "passes/zone_bindings.glsl"

layout(set = 0, binding = kBindHiz, std430) buffer Hiz { float hiz[]; };
layout(set = 0, binding = kBindProvenance, std430) buffer Provenance { uint provenance[]; };
layout(set = 0, binding = kBindPixels, std430) buffer Pixels { uint pixels[]; };
layout(set = 0, binding = kBindRays, std430) buffer Rays { RayTask rays[]; };
layout(set = 0, binding = kBindRayTexels4) uniform usamplerBuffer ray_texels4;
layout(set = 0, binding = kBindHits, std430) buffer Hits { HitRecord hits[]; };
layout(set = 0, binding = kBindFallbackRays, std430) buffer FallbackQueue { FallbackRays fallback_rays[]; };
layout(set = 0, binding = kBindCounters, std430) buffer CounterBlock { Counters counters; };
layout(set = 0, binding = kBindDepth) uniform sampler2D depth_image;
layout(set = 0, binding = kBindSurface) uniform usampler2D surface_image;
layout(set = 0, binding = kBindIrradiance) uniform sampler2D irradiance_image;
layout(set = 0, binding = kBindReflection, rgba16f) uniform writeonly image2D reflection_image;

// Whether page_fetch.glsl checks every word that it reads: for tests. Off, no trace of it is left in the pipeline.
layout(constant_id = 5) const uint kCheckAccess = 0u;
#define ACCESS_COUNTER counters.out_of_page

// 1: as GPUs like it, with a thread a pixel and counters raised once a subgroup; 0: as CPUs do.
layout(constant_id = 10) const uint kThreadPerPixel = 0u;

// A queued ray, by the path that pages are read by.
RayTask load_ray(uint index) {
  if (kPoolPath != kPoolTexels) return rays[index];
  const vec4 a = uintBitsToFloat(texelFetch(ray_texels4, int(2u * index)));
  const uvec4 b = texelFetch(ray_texels4, int(2u * index + 1u));
  return RayTask(a.x, a.y, a.z, a.w, uintBitsToFloat(b.x), uintBitsToFloat(b.y), uintBitsToFloat(b.z), b.w);
}

// Radiance as a half float stores it: clamped, lest it become infinite, and rounded to nearest on every device; image
// stores round as the driver likes (Mesa 22.3 lavapipe: towards zero).
vec4 pack_radiance(vec3 rgb, float alpha) {
  const vec3 clamped = min(rgb, vec3(60000.0));
  return vec4(unpackHalf2x16(packHalf2x16(clamped.rg)), unpackHalf2x16(packHalf2x16(vec2(clamped.b, 0.0))).x, alpha);
}
