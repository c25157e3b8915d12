// SPDX-License-Identifier: Apache-2.0
// A plain BVH2 with both children's boxes in a 64-byte node, nearer child first, one stack a ray (Aila & Laine 2009).
// 48 bytes a triangle: three corners, the index in the first one's fourth component.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "bench/bench_rays.glsl"
#include "bench/float_tests.glsl"

layout(constant_id = 1) const int kStackSize = 64;  // at least the tree's depth

struct Bvh2Node {
  vec4 min0_max0x;
  vec4 max0yz_min1xy;
  vec4 min1z_max1;
  uvec4 refs;  // two of: kLeaf | count << 27 | first triangle, or a node
};

struct Bvh2Triangle {
  uvec4 a_index;
  vec4 b;
  vec4 c;
};

layout(set = 0, binding = 2, std430) readonly buffer Nodes { Bvh2Node nodes[]; };
layout(set = 0, binding = 3, std430) readonly buffer Triangles { Bvh2Triangle triangles[]; };

const uint kLeaf = 0x80000000u;
const uint kDone = 0xFFFFFFFFu;

void main() {
  const uint ray = bench_ray_index();
  if (ray >= bench_ray_count) return;
  const vec3 origin = bench_origin(ray);
  const vec3 direction = bench_direction(ray);
  const vec3 reciprocal = float_reciprocal(direction);
  const RayShear shear = shear_of(direction);
  float t_max = kFarthest;
  uint nearest = kMiss;
  uint stack[kStackSize];
  int size = 0;
  uint ref = 0u;
  while (ref != kDone) {
    uint next = kDone;
    if ((ref & kLeaf) == 0u) {
      const vec4 a = nodes[ref].min0_max0x;
      const vec4 b = nodes[ref].max0yz_min1xy;
      const vec4 c = nodes[ref].min1z_max1;
      const uvec2 refs = nodes[ref].refs.xy;
      float near0;
      float near1;
      const bool hits0 = hits_box(a.xyz, vec3(a.w, b.xy), origin, reciprocal, t_max, near0);
      const bool hits1 = hits_box(vec3(b.zw, c.x), c.yzw, origin, reciprocal, t_max, near1);
      if (hits0 && hits1) {
        const bool swap = near1 < near0;
        next = swap ? refs.y : refs.x;
        stack[size++] = swap ? refs.x : refs.y;
      } else {
        next = hits0 ? refs.x : (hits1 ? refs.y : kDone);
      }
    } else {
      const uint first = ref & 0x07FFFFFFu;
      const uint end = first + ((ref >> 27) & 15u);
      for (uint i = first; i < end; ++i) {
        float t;
        if (hits_triangle(uintBitsToFloat(triangles[i].a_index.xyz), triangles[i].b.xyz, triangles[i].c.xyz, origin,
                           shear, t) &&
            t >= 0.0 && t < t_max) {
          t_max = t;
          nearest = i;
          if (kAnyHit != 0u) break;
        }
      }
      if (kAnyHit != 0u && nearest != kMiss) break;
    }
    if (next == kDone && size > 0) next = stack[--size];
    ref = next;
  }
  if (nearest != kMiss) nearest = triangles[nearest].a_index.w;
  bench_write(ray, t_max, nearest);
}
