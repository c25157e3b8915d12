// SPDX-License-Identifier: Apache-2.0
// Closest and any hit against one set of resident zones. Include once per set with
//   PAGE_NAME(x)  the set's prefix     POOL, ZONES, TOP  its buffers
// Everything runs in lattice units relative to the camera's lattice point: multiplying by a power of two is exact, so
// distances convert to metres without loss.

#include "page_fetch.glsl"

// A hit on the surface that the ray itself leaves, seen through a proxy that lies up to `error_m` off it, is no hit: the
// proxy's measured error bound decides, not a constant (the thesis's self-reflection fault). Such a face winds as the
// surface does; a façade across the street winds against it and counts however coarse the proxy is.
bool PAGE_NAME(own_surface)(TraceRay ray, float t_m, float error_m, vec3 a, vec3 b, vec3 c) {
  const float height_m = abs(t_m * dot(ray.direction, ray.plane));
  const vec3 n = cross(b - a, c - a);
  return height_m <= error_m && dot(n, ray.plane) > 0.7 * length(n);
}

// any: stop at the first hit. A ray that reaches the step bound comes back as kHitLost.
HitRecord PAGE_NAME(trace)(TraceRay ray, bool any) {
  const float step_m = frame.sun_radiance.w;
  const float per_m = 1.0 / step_m;
  const vec3 origin = ray.origin * per_m;
  const vec3 reciprocal = safe_reciprocal(ray.direction);
  const Shear shear = make_shear(ray.direction);
  const bool leaves_surface = dot(ray.plane, ray.plane) > 0.0;
  const float t_min = ray.t_min * per_m;
  float t_max = ray.t_max * per_m;

  HitRecord hit = HitRecord(ray.t_max, kNoZone, 0u, 0u);
  uint stack[kStackSize];
  int sp = 0;
  uint ref = 0u;  // top level's root
  int steps = 0;
  bool done = false;
  for (; !done && steps < kStepLimit; ++steps) {
    uint next = kRefNone;
    if ((ref & kRefLeaf) == 0u) {
      const TopNode node = TOP[ref];
      float near0;
      float near1;
      const ivec3 camera = frame.camera_lattice.xyz;
      const bool hit0 = node.ref0 != kRefNone &&
                        hit_box(vec3(ivec3(node.min0_x, node.min0_y, node.min0_z) - camera),
                                vec3(ivec3(node.max0_x, node.max0_y, node.max0_z) - camera), origin, reciprocal, t_min,
                                t_max, near0);
      const bool hit1 = node.ref1 != kRefNone &&
                        hit_box(vec3(ivec3(node.min1_x, node.min1_y, node.min1_z) - camera),
                                vec3(ivec3(node.max1_x, node.max1_y, node.max1_z) - camera), origin, reciprocal, t_min,
                                t_max, near1);
      if (hit0 && hit1) {
        const bool swap = near1 < near0;
        next = swap ? node.ref1 : node.ref0;
        stack[sp++] = swap ? node.ref0 : node.ref1;
      } else {
        next = hit0 ? node.ref0 : (hit1 ? node.ref1 : kRefNone);
      }
    } else {
      // One zone, to the end: its page stays in cache while lanes of the group are in it.
      const uint slot = ref & ~kRefLeaf;
      const ZoneEntry zone = ZONES[slot];
      const ivec3 offset = PAGE_NAME(zone_offset)(zone);
      const int shift = int(zone.step_shift);
      const int floor_sp = sp;
      uint inner = 0u;
      bool in_zone = true;
      for (; in_zone && steps < kStepLimit; ++steps) {
        uint inner_next = kRefNone;
        if ((inner & kRefLeaf) == 0u) {
          const uint base = zone.page_word + kPageHeaderWords + inner * kBvhNodeWords;
          const uint w0 = POOL[base];
          const uint w1 = POOL[base + 1u];
          const uint w2 = POOL[base + 2u];
          const uint w3 = POOL[base + 3u];
          const uint w4 = POOL[base + 4u];
          const uint w5 = POOL[base + 5u];
          const uint ref0 = POOL[base + 6u];
          const uint ref1 = POOL[base + 7u];
          float near0;
          float near1;
          const bool hit0 =
              hit_box(vec3((ivec3(w0 & 0xFFFFu, w0 >> 16, w1 & 0xFFFFu) << shift) + offset),
                      vec3((ivec3(w1 >> 16, w2 & 0xFFFFu, w2 >> 16) << shift) + offset), origin, reciprocal, t_min,
                      t_max, near0);
          const bool hit1 =
              ref1 != kRefNone &&
              hit_box(vec3((ivec3(w3 & 0xFFFFu, w3 >> 16, w4 & 0xFFFFu) << shift) + offset),
                      vec3((ivec3(w4 >> 16, w5 & 0xFFFFu, w5 >> 16) << shift) + offset), origin, reciprocal, t_min,
                      t_max, near1);
          if (hit0 && hit1) {
            const bool swap = near1 < near0;
            inner_next = swap ? ref1 : ref0;
            stack[sp++] = swap ? ref0 : ref1;
          } else {
            inner_next = hit0 ? ref0 : (hit1 ? ref1 : kRefNone);
          }
        } else {
          const uint first = inner & kRefFirstMask;
          const uint count = (inner >> kRefCountShift) & kRefCountMask;
          for (uint i = 0u; i < count; ++i) {
            vec3 a;
            vec3 b;
            vec3 c;
            uint material;
            PAGE_NAME(fetch_triangle)(zone, offset, first + i, a, b, c, material);
            float t;
            if (hit_triangle(a, b, c, origin, shear, t) && t >= t_min && t < t_max &&
                !(leaves_surface && PAGE_NAME(own_surface)(ray, t * step_m, zone.error_m + 2.0 * step_m, a, b, c))) {
              t_max = t;
              hit = HitRecord(t * step_m, slot, first + i, 0u);
              if (any) {
                done = true;
                in_zone = false;
              }
            }
          }
        }
        if (inner_next != kRefNone) {
          inner = inner_next;
        } else if (sp == floor_sp) {
          in_zone = false;
        } else {
          inner = stack[--sp];
        }
      }
      if (in_zone) break;  // the step bound, inside a zone: lost, even where nothing else is on the stack
    }
    if (next != kRefNone) {
      ref = next;
    } else if (sp == 0) {
      done = true;
    } else {
      ref = stack[--sp];
    }
  }
  if (!done) hit.zone = kHitLost;
  return hit;
}
