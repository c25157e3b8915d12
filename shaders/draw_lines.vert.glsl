// SPDX-License-Identifier: Apache-2.0
// The BVH view (thesis, Figure 3.2): one instance a zone; pass_constants.a = 0 draws the edges of the proxies' triangles
// (6 vertices a triangle), 1 the boxes of the leaves (48 vertices a node: two children, twelve edges).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "scene_bindings.glsl"

#define PAGE_NAME(x) proxy_##x
#define POOL proxy_pool
#include "page_fetch.glsl"

layout(location = 0) flat out vec3 out_color;

void main() {
  const ZoneEntry zone = proxy_zones[gl_InstanceIndex];
  const ivec3 offset = proxy_zone_offset(zone);
  const float step_m = frame.sun_radiance.w;
  const uint id = uint(gl_VertexIndex);
  vec3 p;
  bool shown = true;
  if (pass_constants.a == 0u) {
    vec3 a;
    vec3 b;
    vec3 c;
    uint material;
    proxy_fetch_triangle(zone, offset, id / 6u, a, b, c, material);
    const uint corner = ((id % 6u + 1u) / 2u) % 3u;
    p = corner == 0u ? a : (corner == 1u ? b : c);
    out_color = vec3(0.15, 0.95, 0.25);
  } else {
    const uint base = zone.page_word + kPageHeaderWords + (id / 48u) * kBvhNodeWords;
    const bool second = id % 48u >= 24u;
    const uint first_word = base + (second ? 3u : 0u);
    const uint w0 = POOL[first_word];
    const uint w1 = POOL[first_word + 1u];
    const uint w2 = POOL[first_word + 2u];
    const uint ref = POOL[base + (second ? 7u : 6u)];
    shown = ref != kRefNone && (ref & kRefLeaf) != 0u;
    const int shift = int(zone.step_shift);
    const vec3 lo = vec3((ivec3(w0 & 0xFFFFu, w0 >> 16, w1 & 0xFFFFu) << shift) + offset);
    const vec3 hi = vec3((ivec3(w1 >> 16, w2 & 0xFFFFu, w2 >> 16) << shift) + offset);
    // Edge e runs along axis e / 4 between the corners that differ in it; e % 4 picks the other two coordinates.
    const uint e = (id % 24u) / 2u;
    const uint axis = e / 4u;
    const bool end = (id & 1u) != 0u;
    const bool u = (e & 1u) != 0u;
    const bool v = (e & 2u) != 0u;
    const bvec3 side = axis == 0u ? bvec3(end, u, v) : (axis == 1u ? bvec3(u, end, v) : bvec3(u, v, end));
    p = mix(lo, hi, side);
    out_color = vec3(1.0, 0.35, 0.75);
  }
  p *= step_m;
  // Drawn a little towards the eye, or the edges would vanish in the surfaces they bound.
  p = frame.eye.xyz + (p - frame.eye.xyz) * 0.996;
  gl_Position = shown ? frame.view_projection * vec4(p, 1.0) : vec4(0.0, 0.0, -1.0, 1.0);
}
