// SPDX-License-Identifier: Apache-2.0
// Ray against box and triangle in plain floats, for the peers' layouts. Kept apart from our own traversal, so that the
// peers stay what they are while ours changes.

const float kFarthest = 3.4028235e38;

// A finite reciprocal that keeps the sign of zero, so that the slab test never computes 0 * inf.
vec3 float_reciprocal(vec3 d) {
  const vec3 s = vec3(floatBitsToInt(d.x) < 0 ? -1.0 : 1.0, floatBitsToInt(d.y) < 0 ? -1.0 : 1.0,
                      floatBitsToInt(d.z) < 0 ? -1.0 : 1.0);
  return s / max(abs(d), vec3(1e-18));
}

// Slab test from t = 0 on; the far distance is padded by 2 ulp so that rounding never loses a box (Ize 2013,
// section 3).
bool hits_box(vec3 lo, vec3 hi, vec3 origin, vec3 reciprocal, float t_max, out float t_near) {
  precise vec3 t0 = (lo - origin) * reciprocal;
  precise vec3 t1 = (hi - origin) * reciprocal;
  const vec3 near = min(t0, t1);
  const vec3 far = max(t0, t1);
  t_near = max(max(near.x, near.y), max(near.z, 0.0));
  return t_near <= min(min(min(far.x, far.y), far.z) * 1.00000024, t_max);
}

// Woop, Benthin & Wald 2013: the ray's shear along its longest axis, and the test, both sides, edges inclusive.
struct RayShear {
  int longest;
  vec3 scale;
};

vec3 longest_last(vec3 v, int longest) { return longest == 2 ? v : (longest == 0 ? v.yzx : v.zxy); }

RayShear shear_of(vec3 direction) {
  const vec3 a = abs(direction);
  const int longest = a.x > a.y ? (a.x > a.z ? 0 : 2) : (a.y > a.z ? 1 : 2);
  const vec3 d = longest_last(direction, longest);
  return RayShear(longest, vec3(d.x / d.z, d.y / d.z, 1.0 / d.z));
}

bool hits_triangle(vec3 a, vec3 b, vec3 c, vec3 origin, RayShear shear, out float t) {
  const vec3 pa = longest_last(a - origin, shear.longest);
  const vec3 pb = longest_last(b - origin, shear.longest);
  const vec3 pc = longest_last(c - origin, shear.longest);
  precise vec2 qa = pa.xy - shear.scale.xy * pa.z;
  precise vec2 qb = pb.xy - shear.scale.xy * pb.z;
  precise vec2 qc = pc.xy - shear.scale.xy * pc.z;
  // Products are compared, never subtracted first: two triangles that share an edge agree on its side.
  precise float u0 = qc.x * qb.y;
  precise float u1 = qc.y * qb.x;
  precise float v0 = qa.x * qc.y;
  precise float v1 = qa.y * qc.x;
  precise float w0 = qb.x * qa.y;
  precise float w1 = qb.y * qa.x;
  const bool inside = (u0 >= u1 && v0 >= v1 && w0 >= w1) || (u0 <= u1 && v0 <= v1 && w0 <= w1);
  const float u = u0 - u1;
  const float v = v0 - v1;
  const float w = w0 - w1;
  const float sum = u + v + w;
  t = (u * pa.z + v * pb.z + w * pc.z) * shear.scale.z / sum;
  return inside && sum != 0.0;
}
