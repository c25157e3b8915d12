// SPDX-License-Identifier: Apache-2.0
// The BVH view (thesis, Figure 3.2): one instance a zone; pass_constants.a = 0 draws the edges of the proxies'
// triangles (6 vertices a triangle), 1 the boxes of the leaves (192 vertices a node: eight children, twelve edges).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "passes/zone_bindings.glsl"

#include "page/zone_set.glsl"
#include "page/page_fetch.glsl"

layout(location = 0) flat out vec3 out_color;

void main() {
  const ZoneEntry zone = zones[gl_InstanceIndex];
  const float step_m = frame.step_m;
  const uint id = uint(gl_VertexIndex);
  vec3 p;
  bool shown = true;
  if (pass_constants.a == 0u) {
    vec3 a;
    vec3 b;
    vec3 c;
    const page_Cluster cluster = page_find_cluster(zone.page_word, id / 6u);
    page_load_corners(cluster, page_load(cluster.triangle_word + id / 6u - cluster.first_triangle), a, b, c);
    const uint corner = ((id % 6u + 1u) / 2u) % 3u;
    p = corner == 0u ? a : (corner == 1u ? b : c);
    out_color = vec3(0.15, 0.95, 0.25);
  } else {
    const uint node = zone.page_word + kPageHeaderWords + (id / 192u) * kPageNodeWords;
    const uint slot = id % 192u / 24u;
    const uvec4 head = page_load4(node);
    shown = (head.w >> (24u + slot) & 1u) != 0u;
    const uint word = node + 8u + slot / 4u;
    const uint shift = 8u * (slot % 4u);
    const uvec3 low = uvec3(page_load(word), page_load(word + 2u), page_load(word + 4u)) >> shift & 0xFFu;
    const uvec3 high = uvec3(page_load(word + 6u), page_load(word + 8u), page_load(word + 10u)) >> shift & 0xFFu;
    const uvec3 exponent = uvec3(head.w, head.w >> 5, head.w >> 10) & 31u;
    const ivec3 from = ivec3(head.xyz) - frame.camera_lattice.xyz;
    const vec3 lo = vec3(from + ivec3(low << exponent));
    const vec3 hi = vec3(from + ivec3(high << exponent));
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
