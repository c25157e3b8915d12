// SPDX-License-Identifier: Apache-2.0
// The descriptor set that the compute passes share.
#include "passes/scene_bindings.glsl"

layout(set = 0, binding = kBindHiz, std430) buffer Hiz { float hiz[]; };
layout(set = 0, binding = kBindLit, std430) buffer Lit { uvec2 lit[]; };
layout(set = 0, binding = kBindReflection, std430) buffer Reflection { uvec2 reflection[]; };
layout(set = 0, binding = kBindProvenance, std430) buffer Provenance { uint provenance[]; };
layout(set = 0, binding = kBindPixels, std430) buffer Pixels { uint pixels[]; };
layout(set = 0, binding = kBindRays, std430) buffer Rays { RayTask rays[]; };
layout(set = 0, binding = kBindHits, std430) buffer Hits { HitRecord hits[]; };
layout(set = 0, binding = kBindCounters, std430) buffer CounterBlock { Counters counters; };
layout(set = 0, binding = kBindOutput, std430) buffer Output { uint output_rgba[]; };
layout(set = 0, binding = kBindRayTexels4) uniform usamplerBuffer ray_texels4;
layout(set = 0, binding = kBindFallbackRays, std430) buffer FallbackQueue { FallbackRays fallback_rays[]; };
layout(set = 0, binding = kBindDepth) uniform sampler2D depth_image;
layout(set = 0, binding = kBindSurface) uniform usampler2D surface_image;

// Whether page_fetch.glsl checks every word that it reads: for tests. Off, no trace of it is left in the pipeline.
layout(constant_id = 5) const uint kCheckAccess = 0u;
#define ACCESS_COUNTER counters.out_of_page

// A queued ray, by the path that pages are read by.
RayTask load_ray(uint index) {
  if (kPoolPath != kPoolTexels) return rays[index];
  const vec4 a = uintBitsToFloat(texelFetch(ray_texels4, int(2u * index)));
  const uvec4 b = texelFetch(ray_texels4, int(2u * index + 1u));
  return RayTask(a.x, a.y, a.z, a.w, uintBitsToFloat(b.x), uintBitsToFloat(b.y), uintBitsToFloat(b.z), b.w);
}
