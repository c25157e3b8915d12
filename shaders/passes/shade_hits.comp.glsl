// SPDX-License-Identifier: Apache-2.0
// Shades what the traced rays hit, with one shadow ray each against the same zones where the bake leaves it open.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "passes/bindings.glsl"
#include "adapter/load_surface.glsl"
#include "adapter/sky.glsl"
#include "passes/count_rays.glsl"
#include "shading/shading.glsl"
#include "shading/baked_light.glsl"
#include "traverse/trace.glsl"
layout(local_size_x = 64) in;
#include "traverse/list_index.glsl"

struct HitSurface {
  ZoneEntry zone;
  vec3 geometric_normal;  // unit, as wound
  vec3 shading_normal;   // unit, of the curved surface that the triangle stands in for, if it does
  SurfaceAttributes attributes;
};

#include "page/zone_set.glsl"
#include "page/page_layout.glsl"
#include "traverse/traverse.glsl"
#include "page/page_appearance.glsl"
#include "traverse/hit_surface.glsl"
#include "page/end_set.glsl"

void main() {
  const uint i = list_index();
  if (i >= counters.ray_count) return;
  const RayTask task = load_ray(i);
  const HitRecord hit = hits[i];
  const vec3 direction = vec3(task.dir_x, task.dir_y, task.dir_z);
  vec3 color = sky_radiance(direction);
  uint source = kSourceSky;
  if (hit.triangle_word == kHitLost) {
    source = kSourceLost;
    atomicAdd(counters.rays_lost, 1u);  // never expected
  } else if (hit.triangle_word == kHitNone) {
    COUNT_RAYS(counters.rays_sky);
  } else {
    const vec3 position = vec3(task.origin_x, task.origin_y, task.origin_z) + direction * hit.t;
    const ivec2 asked = ivec2(hit.pixel % frame.width, hit.pixel / frame.width);
    const float footprint_m = pixel_footprint_m(frame.near_m / max(texelFetch(depth_image, asked, 0).x, 1e-12) + hit.t);
    const HitSurface h = page_hit_surface(hit.triangle_word, position, footprint_m);
    const vec3 normal = dot(h.geometric_normal, direction) > 0.0 ? -h.geometric_normal : h.geometric_normal;
    const vec3 shading_normal = dot(h.shading_normal, direction) < 0.0 ? h.shading_normal : normal;
    float visibility = h.attributes.sun == kSunLit ? 1.0 : 0.0;
    if (h.attributes.sun == kSunUnknown && dot(normal, frame.sun_direction.xyz) > 0.0) {
      const float start_m = 2e-3 + 2e-5 * hit.t;
      const TraceRay ray = TraceRay(position + normal * start_m, 0.0, frame.sun_direction.xyz, frame.ray_length_m,
                                    pack_normal(h.geometric_normal));
      const uint blocker = page_trace(ray, true).triangle_word;
      visibility = blocker == kHitNone ? 1.0 : 0.0;
    }
    color = shade_mirrored(h.attributes, shading_normal, direction,
                           irradiance(h.attributes, shading_normal, visibility), hit.t);
    if ((h.zone.flags & kZoneCoarse) != 0u) {
      source = kSourceProxyCoarse;
      COUNT_RAYS(counters.rays_proxy_coarse);
    } else {
      source = kSourceProxy;
      COUNT_RAYS(counters.rays_proxy);
    }
    source |= h.zone.node << kSourceBits;
  }
  imageStore(reflection_image, ivec2(hit.pixel % frame.width, hit.pixel / frame.width), pack_radiance(color, 1.0));
  provenance[hit.pixel] = source;
}
