// SPDX-License-Identifier: Apache-2.0
// The part of tracing that does not depend on which set of zones is traced.

layout(constant_id = 0) const int kStackSize = 64;  // from the data: deepest page + deepest top level

// Nodes and leaves a ray may visit; a heavy ray of a city takes some two hundred. With up to eight triangles a leaf this
// stays below the 65,535 iterations over all loops after which lavapipe ends them silently.
const int kStepLimit = 4096;

struct TraceRay {
  vec3 origin;  // metres, relative to camera_lattice
  float t_min;
  vec3 direction;  // unit
  float t_max;
  vec3 plane;  // normal, as the model winds it, of the surface that the ray leaves; or zero
};

// A finite reciprocal that keeps the sign of zero, so that the slab test never meets 0 * inf.
vec3 safe_reciprocal(vec3 d) {
  const vec3 tiny = vec3(1e-18);
  const vec3 s = vec3((floatBitsToUint(d.x) >> 31) != 0u ? -1.0 : 1.0, (floatBitsToUint(d.y) >> 31) != 0u ? -1.0 : 1.0,
                      (floatBitsToUint(d.z) >> 31) != 0u ? -1.0 : 1.0);
  return s / max(abs(d), tiny);
}

// Slab test; the far distance is padded by 2 ulp so that rounding never loses a box (Ize 2013, section 3).
bool hit_box(vec3 lo, vec3 hi, vec3 origin, vec3 reciprocal, float t_min, float t_max, out float t_near) {
  precise vec3 t0 = (lo - origin) * reciprocal;
  precise vec3 t1 = (hi - origin) * reciprocal;
  const vec3 near = min(t0, t1);
  const vec3 far = max(t0, t1);
  t_near = max(max(near.x, near.y), max(near.z, t_min));
  const float t_far = min(min(far.x, far.y), far.z) * 1.00000024;
  return t_near <= min(t_far, t_max);
}

// Puts the axis in which the ray is longest last.
vec3 permute(vec3 v, int longest) { return longest == 2 ? v : (longest == 0 ? v.yzx : v.zxy); }

// The ray's shear, constant over its triangles (Woop, Benthin & Wald 2013, section 3.1).
struct Shear {
  int longest;
  vec3 scale;
};

Shear make_shear(vec3 d) {
  const vec3 a = abs(d);
  Shear s;
  s.longest = a.x > a.y ? (a.x > a.z ? 0 : 2) : (a.y > a.z ? 1 : 2);
  const vec3 p = permute(d, s.longest);
  s.scale = vec3(p.x / p.z, p.y / p.z, 1.0 / p.z);
  return s;
}

// Watertight ray/triangle test (Woop et al. 2013, section 3.2), both sides. An edge function of exactly zero counts as
// inside for both neighbours: no ray slips between, and a closest hit does not care which of the two it gets.
bool hit_triangle(vec3 a, vec3 b, vec3 c, vec3 origin, Shear s, out float t) {
  const vec3 pa = permute(a - origin, s.longest);
  const vec3 pb = permute(b - origin, s.longest);
  const vec3 pc = permute(c - origin, s.longest);
  precise float ax = pa.x - s.scale.x * pa.z;
  precise float ay = pa.y - s.scale.y * pa.z;
  precise float bx = pb.x - s.scale.x * pb.z;
  precise float by = pb.y - s.scale.y * pb.z;
  precise float cx = pc.x - s.scale.x * pc.z;
  precise float cy = pc.y - s.scale.y * pc.z;
  precise float u0 = cx * by;
  precise float u1 = cy * bx;
  precise float v0 = ax * cy;
  precise float v1 = ay * cx;
  precise float w0 = bx * ay;
  precise float w1 = by * ax;
  // Products are compared, never subtracted first: the sign is right even where the difference rounds to zero.
  const bool positive = u0 >= u1 && v0 >= v1 && w0 >= w1;
  const bool negative = u0 <= u1 && v0 <= v1 && w0 <= w1;
  const float u = u0 - u1;
  const float v = v0 - v1;
  const float w = w0 - w1;
  const float det = u + v + w;
  t = (u * pa.z + v * pb.z + w * pc.z) * s.scale.z / det;
  return (positive || negative) && det != 0.0;
}
