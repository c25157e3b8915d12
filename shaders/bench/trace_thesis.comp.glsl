// SPDX-License-Identifier: Apache-2.0
// The layout of Fredriksson & Scott 2016: 32-byte BVH2 nodes in depth-first order, each with where to go on when it is
// missed; visited unordered, without a stack. 40 bytes a triangle, as many as the thesis spends on index, delta, edge,
// normal and UV: here three corners in floats and the triangle's index.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "bench/bench_rays.glsl"
#include "bench/float_tests.glsl"

struct ThesisNode {
  uvec4 min_skip;  // skip: the node after this one's subtree
  uvec4 max_leaf;  // leaf: count << 28 | first triangle; 0: inner, its first child follows
};

struct ThesisTriangle {
  vec2 a_xy;
  vec2 a_z_b_x;
  vec2 b_yz;
  vec2 c_xy;
  uvec2 c_z_index;
};

layout(set = 0, binding = 2, std430) readonly buffer Nodes { ThesisNode nodes[]; };
layout(set = 0, binding = 3, std430) readonly buffer Triangles { ThesisTriangle triangles[]; };

void main() {
  const uint ray = bench_ray_index();
  if (ray >= bench_ray_count) return;
  const vec3 origin = bench_origin(ray);
  const vec3 direction = bench_direction(ray);
  const vec3 reciprocal = float_reciprocal(direction);
  const RayShear shear = shear_of(direction);
  float t_max = kFarthest;
  uint nearest = kMiss;
  const uint node_count = nodes[0].min_skip.w;
  for (uint at = 0u; at < node_count && (kAnyHit == 0u || nearest == kMiss);) {
    const uvec4 low = nodes[at].min_skip;
    const uvec4 high = nodes[at].max_leaf;
    float t_near;
    if (!hits_box(uintBitsToFloat(low.xyz), uintBitsToFloat(high.xyz), origin, reciprocal, t_max, t_near)) {
      at = low.w;
      continue;
    }
    const uint first = high.w & 0x0FFFFFFFu;
    const uint end = first + (high.w >> 28);
    for (uint i = first; i < end; ++i) {
      const ThesisTriangle p = triangles[i];
      float t;
      const vec3 a = vec3(p.a_xy, p.a_z_b_x.x);
      const vec3 b = vec3(p.a_z_b_x.y, p.b_yz);
      const vec3 c = vec3(p.c_xy, uintBitsToFloat(p.c_z_index.x));
      if (hits_triangle(a, b, c, origin, shear, t) && t >= 0.0 && t < t_max) {
        t_max = t;
        nearest = i;
        if (kAnyHit != 0u) break;
      }
    }
    at = at + 1u;
  }
  if (nearest != kMiss) nearest = triangles[nearest].c_z_index.y;
  bench_write(ray, t_max, nearest);
}
