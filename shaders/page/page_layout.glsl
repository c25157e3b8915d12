// SPDX-License-Identifier: Apache-2.0
// What the traversals ask of the layout that they run over, answered for pages. Needs a set (proxy_set.glsl,
// host_set.glsl) and trace.glsl; page_layout_group.glsl adds what packets ask. `zonecast bench trace` answers the same
// questions for an uncompressed layout (bench/plain_layout.glsl).

#include "page/page_fetch.glsl"

const uint PAGE_NAME(node_words) = kPageNodeWords;

// The children that a ray intersects between t_min and t_max, one bit a slot. The origin is in lattice units relative
// to the camera's lattice point.
uint PAGE_NAME(hit_children)(uint node, vec3 origin, vec3 reciprocal, bvec3 backward, float t_min, float t_max,
                             out NodeRefs refs) {
  const uvec4 h0 = PAGE_NAME(load4)(node);
  const uvec4 h1 = PAGE_NAME(load4)(node + 4u);
  const uvec4 p0 = PAGE_NAME(load4)(node + 8u);
  const uvec4 p1 = PAGE_NAME(load4)(node + 12u);
  const uvec4 p2 = PAGE_NAME(load4)(node + 16u);
  const vec3 from = vec3(ivec3(h0.xyz) - frame.camera_lattice.xyz) - origin;
  const SlabTest slab = make_slab_test(from, h0.w, reciprocal);
  const uvec2 near_x = backward.x ? p1.zw : p0.xy;
  const uvec2 near_y = backward.y ? p2.xy : p0.zw;
  const uvec2 near_z = backward.z ? p2.zw : p1.xy;
  const uvec2 far_x = backward.x ? p0.xy : p1.zw;
  const uvec2 far_y = backward.y ? p0.zw : p2.xy;
  const uvec2 far_z = backward.z ? p1.xy : p2.zw;
  refs = NodeRefs((h0.w >> 16) & 0xFFu, h0.w >> 24, h1.z, node + h1.x, node + h1.y, node + h1.w);
  return hit_four(slab, near_x.x, near_y.x, near_z.x, far_x.x, far_y.x, far_z.x, t_min, t_max) |
         hit_four(slab, near_x.y, near_y.y, near_z.y, far_x.y, far_y.y, far_z.y, t_min, t_max) << 4;
}

void PAGE_NAME(load_triangle)(PAGE_NAME(Cluster) cluster, uint triangle_word, out vec3 a, out vec3 b, out vec3 c) {
  PAGE_NAME(load_corners)(cluster, PAGE_NAME(load)(triangle_word), a, b, c);
}
