// SPDX-License-Identifier: Apache-2.0
// Stands in for the host's lighting: irradiance of every visible surface, with one shadow ray against the host's zones
// where the bake does not say it all.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "passes/bindings.glsl"
#include "shading/surface.glsl"
#include "shading/shading.glsl"
#include "traverse/trace.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
#include "page/full_detail_set.glsl"
#include "page/page_layout.glsl"
#include "traverse/traverse.glsl"
#include "page/end_set.glsl"

void main() {
  const ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, ivec2(frame.size.xy)))) return;
  const uint index = uint(pixel.y) * frame.size.x + uint(pixel.x);
  const Surface s = load_surface(pixel);
  if (s.sky) {
    lit[index] = pack_color(sky_radiance(s.view), 0.0);
    return;
  }
  float visibility = s.attributes.sun == kSunLit ? 1.0 : 0.0;
  if (s.attributes.sun == kSunUnknown && dot(s.normal, frame.sun_direction.xyz) > 0.0) {
    const float start_m = 1e-3 + 1e-5 * s.distance_m;
    const TraceRay ray =
        TraceRay(s.position + s.normal * start_m, 0.0, frame.sun_direction.xyz, frame.forward.w, s.origin_normal);
    visibility = host_trace(ray, true).triangle_word == kHitNone ? 1.0 : 0.0;
  }
  lit[index] = pack_color(irradiance(s.attributes, s.shading_normal, visibility), 0.0);
}
