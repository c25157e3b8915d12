// SPDX-License-Identifier: Apache-2.0
// Closest and any hit of one ray an invocation against one set of zones (proxy_set.glsl, host_set.glsl), by the node
// order of Ylitie, Karras & Laine 2017, section 4: children lie in slots such that `slot ^ octant` is roughly front to
// back; a stack entry is what remains of one node's children.
// Everything runs in lattice units relative to the camera's lattice point: multiplying by a power of two is exact, so
// distances convert to metres without loss.

#include "page_fetch.glsl"
#include "stack.glsl"

// any: stop at the first hit. A ray that reaches the step bound comes back as kHitLost.
TraceHit PAGE_NAME(trace)(TraceRay ray, bool any) {
  const float step_m = frame.sun_radiance.w;
  const float per_m = 1.0 / step_m;
  const vec3 origin = ray.origin * per_m;
  const vec3 reciprocal = safe_reciprocal(ray.direction);
  const Shear shear = make_shear(ray.direction);
  const vec3 sheared_origin = permute(origin, shear.longest);
  const bool leaves_surface = ray.leaves != kNoSurface;
  const vec3 sheared_plane = permute(unpack_normal(ray.leaves), shear.longest);
  const float climb = climb_of(shear.scale, sheared_plane);
  const uint octant = direction_octant(ray.direction);
  const bvec3 backward = lessThan(reciprocal, vec3(0.0));  // as the slab test sees it: -0 runs backwards
  const float t_min = ray.t_min * per_m;
  float t_max = ray.t_max * per_m;
  uint best = kHitNone;

  int sp = 0;
  uvec2 group = root_group(SET_ROOT);
  uint triangles = 0u;  // bit i: triangle i of the node that was visited last is to be tested
  uint triangle_word = 0u;
  uint cluster_word = 0u;
  int steps = 0;
  bool done = false;
  while (!done && steps < kStepLimit) {
    for (; triangles == 0u && !done && steps < kStepLimit; ++steps) {
      if ((group.y >> 24) == 0u) {
        done = sp == 0;
        sp = max(sp - 1, 0);
        group = stack_entry(sp);
      }
      if (!done) {
        const uint node = take_child(group, octant);
        if ((group.y >> 24) != 0u) set_stack_entry(sp++, group);
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
        const uint hits = hit_four(slab, near_x.x, near_y.x, near_z.x, far_x.x, far_y.x, far_z.x, t_min, t_max) |
                          hit_four(slab, near_x.y, near_y.y, near_z.y, far_x.y, far_y.y, far_z.y, t_min, t_max) << 4;
        const uint inner = (h0.w >> 16) & 0xFFu;
        group = uvec2(node + h1.x, order_slots(hits & inner, octant) << 24 | inner);
        triangles = leaf_triangles(hits & (h0.w >> 24), h1.z);
        triangle_word = node + h1.y;
        cluster_word = node + h1.w;
      }
    }
    if (triangles != 0u) {
      const PAGE_NAME(Cluster) cluster = PAGE_NAME(load_cluster)(cluster_word);
      const uint first = triangle_word - cluster.triangle_word;
      const float own_height_m = cluster.error_m + 2.0 * step_m;
      for (; triangles != 0u; triangles &= triangles - 1u) {
        const uint index = first + uint(findLSB(triangles));
        vec3 a;
        vec3 b;
        vec3 c;
        PAGE_NAME(load_corners)(cluster, PAGE_NAME(load)(cluster.triangle_word + index), a, b, c);
        const Triangle shape =
            make_triangle(permute(a, shear.longest), permute(b, shear.longest), permute(c, shear.longest));
        float t;
        const bool met = hit_triangle(shape, sheared_origin, shear.scale, t);
        const bool own = leaves_surface && winds_with(shape.normal, sheared_plane) && t * climb * step_m <= own_height_m;
        // Of triangles at the same distance the first in the pool wins, in whatever order they are met.
        const uint hit = hit_at(cluster_word, index);
        if (met && t >= t_min && (t < t_max || (t == t_max && hit < best)) && !own) {
          t_max = t;
          best = hit;
          if (any) {
            done = true;
            triangles = 0u;
            break;
          }
        }
      }
    }
  }
  return TraceHit(t_max * step_m, done ? best : kHitLost);
}
