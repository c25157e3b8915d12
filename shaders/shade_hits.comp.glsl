// SPDX-License-Identifier: Apache-2.0
// Shades what the traced rays met, with one shadow ray each against the same zones.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "bindings.glsl"
#include "surface.glsl"
#include "shading.glsl"
#include "trace.glsl"
layout(constant_id = 2) const uint kTraceHost = 0u;
layout(local_size_x = 64) in;
#include "host_set.glsl"
#include "page_layout.glsl"
#include "traverse.glsl"
#include "end_set.glsl"
#include "proxy_set.glsl"
#include "page_layout.glsl"
#include "traverse.glsl"
#include "end_set.glsl"
#include "list_index.glsl"

void main() {
  const uint i = list_index();
  if (i >= counters.ray_count) return;
  const RayTask task = load_ray(i);
  const HitRecord hit = hits[i];
  const vec3 direction = vec3(task.dir_x, task.dir_y, task.dir_z);
  vec3 color = sky_radiance(direction);
  uint source = kSourceSky;
  if (hit.triangle == kHitLost) {
    source = kSourceLost;
    atomicAdd(counters.rays_lost, 1u);
  } else if (hit.triangle == kHitNone) {
    atomicAdd(counters.rays_sky, 1u);
  } else {
    ZoneEntry zone;
    vec3 a;
    vec3 b;
    vec3 c;
    uint material;
    if (kTraceHost != 0u) {
      const host_Cluster cluster = host_load_cluster(hit_cluster_word(hit.triangle));
      zone = host_zone_of_page(cluster.page_word);
      host_fetch_corners(cluster, hit_index(hit.triangle), a, b, c, material);
    } else {
      const proxy_Cluster cluster = proxy_load_cluster(hit_cluster_word(hit.triangle));
      zone = proxy_zone_of_page(cluster.page_word);
      proxy_fetch_corners(cluster, hit_index(hit.triangle), a, b, c, material);
    }
    const vec3 outward = normalize(cross(b - a, c - a));
    const vec3 normal = dot(outward, direction) > 0.0 ? -outward : outward;
    float visibility = 0.0;
    if (dot(normal, frame.sun_direction.xyz) > 0.0) {
      const vec3 position = vec3(task.origin_x, task.origin_y, task.origin_z) + direction * hit.t;
      const float start_m = 2e-3 + 2e-5 * hit.t;
      const TraceRay ray =
          TraceRay(position + normal * start_m, 0.0, frame.sun_direction.xyz, frame.forward.w, pack_normal(outward));
      const uint blocker = kTraceHost != 0u ? host_trace(ray, true).triangle : proxy_trace(ray, true).triangle;
      visibility = blocker == kHitNone ? 1.0 : 0.0;
    }
    color = shade_mirrored(materials[material], normal, direction, visibility, hit.t);
    if ((zone.flags & kZoneCoarse) != 0u) {
      source = kSourceProxyCoarse;
      atomicAdd(counters.rays_proxy_coarse, 1u);
    } else {
      source = kSourceProxy;
      atomicAdd(counters.rays_proxy, 1u);
    }
    source |= zone.node << kSourceBits;
  }
  reflection[hit.pixel] = pack_color(color, 0.0);
  provenance[hit.pixel] = source;
}
