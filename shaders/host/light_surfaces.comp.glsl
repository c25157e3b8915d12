// SPDX-License-Identifier: Apache-2.0
// Stands in for the host's lighting: irradiance of every visible surface, with one shadow ray against the host's zones
// where the bake does not say it all.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "host/host_bindings.glsl"
#include "adapter/load_surface.glsl"
#include "adapter/sky.glsl"
#include "shading/shading.glsl"
#include "traverse/trace.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
#include "page/zone_set.glsl"
#include "page/page_layout.glsl"
#include "traverse/traverse.glsl"
#include "page/end_set.glsl"

void main() {
  const ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, ivec2(frame_size())))) return;
  const Surface s = load_surface(pixel);
  if (s.sky) {
    imageStore(irradiance_out, pixel, pack_radiance(sky_radiance(s.view), 0.0));
    return;
  }
  float visibility = s.attributes.sun == kSunLit ? 1.0 : 0.0;
  if (s.attributes.sun == kSunUnknown && dot(s.normal, frame.sun_direction.xyz) > 0.0) {
    const float start_m = 1e-3 + 1e-5 * s.distance_m;
    const TraceRay ray =
        TraceRay(s.position + s.normal * start_m, 0.0, frame.sun_direction.xyz, frame.ray_length_m, s.origin_normal);
    visibility = page_trace(ray, true).triangle_word == kHitNone ? 1.0 : 0.0;
  }
  imageStore(irradiance_out, pixel, pack_radiance(irradiance(s.attributes, s.shading_normal, visibility), 0.0));
}
