// SPDX-License-Identifier: Apache-2.0
// The part of tracing that does not depend on which set of zones is traced.

#include "page/octahedral.glsl"

layout(constant_id = 0) const int kStackSize = 32;  // from the data: deepest page + deepest top level

layout(constant_id = 9) const int kStepLimit = 1900;  // nodes that a ray may visit; see TraceLimits

struct TraceRay {
  vec3 origin;  // metres, relative to camera_lattice
  float t_min;
  vec3 direction;  // unit
  float t_max;
  uint origin_normal;  // as in RayTask
};

struct TraceHit {
  float t;             // metres
  uint triangle_word;  // as in HitRecord
};

// A finite reciprocal that keeps the sign of zero, so that the slab test never computes 0 * inf.
vec3 safe_reciprocal(vec3 d) {
  const vec3 tiny = vec3(1e-18);
  const vec3 s = vec3((floatBitsToUint(d.x) >> 31) != 0u ? -1.0 : 1.0, (floatBitsToUint(d.y) >> 31) != 0u ? -1.0 : 1.0,
                      (floatBitsToUint(d.z) >> 31) != 0u ? -1.0 : 1.0);
  return s / max(abs(d), tiny);
}

// Bit per axis in which the ray runs backwards.
uint direction_octant(vec3 d) { return (d.x < 0.0 ? 1u : 0u) | (d.y < 0.0 ? 2u : 0u) | (d.z < 0.0 ? 4u : 0u); }

// What remains to be visited of one node's children: x = word of its first child node; y = from bit 24 the children
// hit, one bit a slot in front-to-back order, and in the low byte which slots are nodes.
uvec2 root_group(uint root) { return uvec2(root, 1u << 24); }

// What a node has of its children, beside their boxes.
struct NodeRefs {
  uint inner;   // bit per slot: the child is a node
  uint leaves;  // or triangles
  uint counts;  // of triangles, four bits a slot
  uint child_word;     // of the first child node; the others follow in the order of their slots
  uint triangle_word;  // of the first triangle; the others follow in the order of their slots
  uint cluster_word;   // of what all those triangles are in
};

// Takes the nearest child out of a group and returns its node's word.
uint take_child(inout uvec2 group, uint octant, uint node_words) {
  const uint first = uint(findLSB(group.y >> 24));
  const uint slot = first ^ octant;
  const uint below = group.y & ((1u << slot) - 1u) & 0xFFu;
  group.y &= ~(1u << (24u + first));
  return group.x + node_words * uint(bitCount(below));
}

// Bits by slot to bits by `slot ^ octant`.
uint order_slots(uint bits, uint octant) {
  bits = (octant & 1u) != 0u ? (bits & 0x55u) << 1 | (bits >> 1 & 0x55u) : bits;
  bits = (octant & 2u) != 0u ? (bits & 0x33u) << 2 | (bits >> 2 & 0x33u) : bits;
  return (octant & 4u) != 0u ? (bits & 0x0Fu) << 4 | (bits >> 4 & 0x0Fu) : bits;
}

// The triangles of the leaves that were hit, as bits counted from the node's first triangle.
uint leaf_triangles(uint leaves, uint counts) {
  uint bits = 0u;
  if (leaves == 0u) return bits;
  uint first = 0u;
  for (int slot = 0; slot < int(kNodeWidth); ++slot) {
    const uint count = (counts >> (4 * slot)) & 15u;
    bits |= (leaves >> slot & 1u) != 0u ? ((1u << count) - 1u) << first : 0u;
    first += count;
  }
  return bits;
}

// The triangles of a slot, none unless it is a leaf.
uint slot_triangles(uint counts, uint slot) {
  const uint below = counts & ((1u << (4u * slot)) - 1u);
  const uint first = ((below & 0x0F0F0F0Fu) + (below >> 4 & 0x0F0F0F0Fu)) * 0x01010101u >> 24;
  return ((1u << (counts >> (4u * slot) & 15u)) - 1u) << first;
}

// Plane q, a byte, is read as v = 1 + q / 2^15 by putting it into a float's mantissa: converting integers costs
// discrete GPUs four times as much. Entry distance is v * scale + near_start, exit distance v * scale + far_start; the
// true one is (q * 2^e + from) / d. With the scale 2^15 times as large and the start less that scale, floats are off by
// at most 9 units of 2^-24 of |from / d|, the reciprocal's 2.5 ulp included, and 4 of |scale|: widening both starts by
// 16 units of their sum covers it and costs a 32nd of a grid cell. (The usual slab test with fused multiply-add has no
// such bound and loses boxes far from the origin; Ize 2013 pads the far distance only, which holds for (plane - origin)
// * reciprocal.)
struct SlabTest {
  vec3 scale;
  vec3 near_start;
  vec3 far_start;
};

SlabTest make_slab_test(vec3 from, uint exponents, vec3 reciprocal) {
  const uvec3 e = uvec3(exponents, exponents >> 5, exponents >> 10) & 31u;
  const vec3 scale = uintBitsToFloat((e + (127u + 15u)) << 23) * reciprocal;
  const vec3 start = from * reciprocal;
  const vec3 pad = (abs(start) + abs(scale)) * (16.0 / 16777216.0);
  return SlabTest(scale, start - scale - pad, start - scale + pad);
}

// Byte i of four planes, as v.
float plane_at(uint planes, int i) {
  return uintBitsToFloat(((i == 0 ? planes << 8 : planes >> (8 * i - 8)) & 0xFF00u) | 0x3F800000u);
}

// Four children at once: bit i is set when the ray intersects child i between t_min and t_max. Distances are compared
// as integers: IEEE floats of one sign order alike, and a negative exit distance loses to t_min >= 0 however it
// compares with other negatives. (A minimum of floats costs llvmpipe three instructions for NaN, one of integers costs
// one.)
uint hit_four(SlabTest s, uint near_x, uint near_y, uint near_z, uint far_x, uint far_y, uint far_z, float t_min,
              float t_max) {
  const int least = floatBitsToInt(t_min);
  const int most = floatBitsToInt(t_max);
  uint hits = 0u;
  for (int i = 0; i < 4; ++i) {
    const int x0 = floatBitsToInt(plane_at(near_x, i) * s.scale.x + s.near_start.x);
    const int y0 = floatBitsToInt(plane_at(near_y, i) * s.scale.y + s.near_start.y);
    const int z0 = floatBitsToInt(plane_at(near_z, i) * s.scale.z + s.near_start.z);
    const int x1 = floatBitsToInt(plane_at(far_x, i) * s.scale.x + s.far_start.x);
    const int y1 = floatBitsToInt(plane_at(far_y, i) * s.scale.y + s.far_start.y);
    const int z1 = floatBitsToInt(plane_at(far_z, i) * s.scale.z + s.far_start.z);
    const int enter = max(max(x0, y0), max(z0, least));
    const int leave = min(min(x1, y1), min(z1, most));
    hits |= enter <= leave ? 1u << i : 0u;
  }
  return hits;
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

// What all rays share that are tested against a triangle. Permuted; differences of lattice points are exact.
struct Triangle {
  vec3 a;
  vec3 b;
  vec3 c;
  vec3 normal;  // as it winds
  float z_low;
  float z_high;
};

Triangle make_triangle(vec3 a, vec3 b, vec3 c) {
  const vec3 ab = b - a;
  const vec3 ac = c - a;
  precise float x0 = ab.y * ac.z;
  precise float x1 = ab.z * ac.y;
  precise float y0 = ab.z * ac.x;
  precise float y1 = ab.x * ac.z;
  precise float z0 = ab.x * ac.y;
  precise float z1 = ab.y * ac.x;
  return Triangle(a, b, c, vec3(x0 - x1, y0 - y1, z0 - z1), min(min(a.z, b.z), c.z), max(max(a.z, b.z), c.z));
}

// The axis and which way along it, in three bits.
uint axis_code(Shear s) { return uint(s.longest) << 1 | (s.scale.z < 0.0 ? 1u : 0u); }

// Watertight ray/triangle test (Woop et al. 2013, section 3.2), both sides; triangle and origin are permuted. An edge
// function of exactly zero counts as inside for both neighbours: no ray slips between. The distance is not theirs,
// weighted by edge functions, which loses a sliver by its length times the rounding of its width: it is that of the
// triangle's plane, held within the triangle's own extent where the ray runs along it. All of it is `precise`, so that
// every kernel finds the same distance.
bool hit_triangle(Triangle s, vec3 origin, vec3 scale, out float t) {
  const vec3 pa = s.a - origin;
  const vec3 pb = s.b - origin;
  const vec3 pc = s.c - origin;
  precise float ax = pa.x - scale.x * pa.z;
  precise float ay = pa.y - scale.y * pa.z;
  precise float bx = pb.x - scale.x * pb.z;
  precise float by = pb.y - scale.y * pb.z;
  precise float cx = pc.x - scale.x * pc.z;
  precise float cy = pc.y - scale.y * pc.z;
  precise float u0 = cx * by;
  precise float u1 = cy * bx;
  precise float v0 = ax * cy;
  precise float v1 = ay * cx;
  precise float w0 = bx * ay;
  precise float w1 = by * ax;
  // Products are compared, never subtracted first: the sign is right even where the difference rounds to zero.
  const bool positive = u0 >= u1 && v0 >= v1 && w0 >= w1;
  const bool negative = u0 <= u1 && v0 <= v1 && w0 <= w1;
  precise float off = s.normal.x * pa.x + s.normal.y * pa.y + s.normal.z * pa.z;
  precise float facing = s.normal.x * scale.x + s.normal.y * scale.y + s.normal.z;
  const float low = s.z_low - origin.z;
  const float high = s.z_high - origin.z;
  precise float z = off / facing;
  // Comparisons, because llvmpipe spends three instructions on a minimum for NaN, which z is not.
  z = facing == 0.0 || z < low ? low : z;
  z = z > high ? high : z;
  precise float distance = z * scale.z;
  t = distance;
  return positive != negative;  // both: seen edge on
}

// A hit on the surface that the ray itself leaves, seen through a proxy that lies up to its error off it, is no hit:
// the proxy's measured error bound decides, not a constant (the thesis's self-reflection fault). Such a face winds as
// the surface does; a façade across the street winds against it and counts however coarse the proxy is.
bool winds_with(vec3 normal, vec3 plane) {
  precise float along = dot(normal, plane);
  return along > 0.7 * length(normal);
}

// How fast a ray leaves its plane: height per distance. Its direction is its shear over `scale.z`. Permuted.
float cos_theta_of(vec3 scale, vec3 plane) {
  precise float cos_theta = (scale.x * plane.x + scale.y * plane.y + plane.z) / scale.z;
  return abs(cos_theta);
}
