// SPDX-License-Identifier: Apache-2.0
// Closest and any hit of one ray an invocation against one set of zones (proxy_set.glsl, host_set.glsl) in some layout
// (page_layout.glsl), by the node order of Ylitie, Karras & Laine 2017, section 4: children lie in slots such that
// `slot ^ octant` is roughly front to back; a stack entry is what remains of one node's children. Everything runs in
// lattice units relative to the camera's lattice point: multiplying by a power of two is exact, so distances convert to
// metres without loss.

#include "traverse/stack.glsl"

// any: stop at the first hit. A ray that reaches the step bound comes back as kHitLost.
TraceHit PAGE_NAME(trace)(TraceRay ray, bool any) {
  const float step_m = frame.step_m;
  const float per_m = 1.0 / step_m;
  const vec3 origin = ray.origin * per_m;
  const vec3 reciprocal = safe_reciprocal(ray.direction);
  const Shear shear = make_shear(ray.direction);
  const vec3 sheared_origin = permute(origin, shear.longest);
  const bool has_origin_surface = ray.origin_normal != kNoSurface;
  const vec3 sheared_plane = permute(unpack_normal(ray.origin_normal), shear.longest);
  const float cos_theta = cos_theta_of(shear.scale, sheared_plane);
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
        const uint node = take_child(group, octant, PAGE_NAME(node_words));
        if ((group.y >> 24) != 0u) set_stack_entry(sp++, group);
        NodeRefs refs;
        const uint hits = PAGE_NAME(hit_children)(node, origin, reciprocal, backward, t_min, t_max, refs);
        group = uvec2(refs.child_word, order_slots(hits & refs.inner, octant) << 24 | refs.inner);
        triangles = leaf_triangles(hits & refs.leaves, refs.counts);
        triangle_word = refs.triangle_word;
        cluster_word = refs.cluster_word;
      }
    }
    if (triangles != 0u) {
      const PAGE_NAME(Cluster) cluster = PAGE_NAME(load_cluster)(cluster_word);
      const float own_height_m = cluster.error_m + 2.0 * step_m;
      for (; triangles != 0u; triangles &= triangles - 1u) {
        const uint word = triangle_word + uint(findLSB(triangles));
        vec3 a;
        vec3 b;
        vec3 c;
        PAGE_NAME(load_triangle)(cluster, word, a, b, c);
        const Triangle shape =
            make_triangle(permute(a, shear.longest), permute(b, shear.longest), permute(c, shear.longest));
        float t;
        const bool inside = hit_triangle(shape, sheared_origin, shear.scale, t);
        const bool own =
            has_origin_surface && winds_with(shape.normal, sheared_plane) && t * cos_theta * step_m <= own_height_m;
        // Of triangles at the same distance the first in the pool wins, in whatever order they are found.
        if (inside && t >= t_min && (t < t_max || (t == t_max && word < best)) && !own) {
          t_max = t;
          best = word;
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
