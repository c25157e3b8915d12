// SPDX-License-Identifier: Apache-2.0
// A frustum: bounds over the rays of a packet that run along the same axis, against which boxes and triangles are
// culled. Sources: frustum bounds of coherent packets after Reshetov, Soupikov & Hurley 2005 ("Multi-level ray tracing
// algorithm"), bounded on the dominant axis after Wald, Ize, Kensler, Knoll & Parker 2006 (grid traversal of packets).
// Positions are permuted, the axis last. Along it z counts forward from the first origin: a ray is at from + slope * z.
// Every bound is padded by more than the roundings of the tests that it stands in for: what the frustum misses, no ray
// hits.

struct Frustum {
  float forward;  // 1 or -1: which way along the axis
  float start;    // forward times the axis's coordinate at z = 0
  float z_last;   // no ray has anything to find beyond
  vec2 from_low;
  vec2 from_high;
  vec2 slope_low;
  vec2 slope_high;
  vec2 reach_low;  // no ray goes below or above, because all run away from there
  vec2 reach_high;
};

const float kFrustumPad = 1e-6;

Frustum empty_frustum(float start, float forward) {
  return Frustum(forward, start, -kNever, vec2(kNever), vec2(-kNever), vec2(kNever), vec2(-kNever), vec2(kNever),
                 vec2(-kNever));
}

// Where along the frustum a ray has come at a distance.
float reach_of(Frustum frustum, vec3 origin, vec3 scale, float t) {
  return origin.z * frustum.forward - frustum.start + t / abs(scale.z);
}

void widen_frustum(inout Frustum frustum, bool member, vec3 origin, vec3 scale, float t_max) {
  const float ahead = origin.z * frustum.forward - frustum.start;
  const vec2 slope = scale.xy * frustum.forward;
  const vec2 from = origin.xy - slope * ahead;
  const vec2 pad = (abs(origin.xy) + abs(slope * ahead)) * kFrustumPad;
  const vec2 slope_pad = abs(slope) * kFrustumPad;
  frustum.from_low = min(frustum.from_low, member ? from - pad : vec2(kNever));
  frustum.from_high = max(frustum.from_high, member ? from + pad : vec2(-kNever));
  frustum.slope_low = min(frustum.slope_low, member ? slope - slope_pad : vec2(kNever));
  frustum.slope_high = max(frustum.slope_high, member ? slope + slope_pad : vec2(-kNever));
  const vec2 low = vec2(slope.x >= 0.0 ? origin.x : -kNever, slope.y >= 0.0 ? origin.y : -kNever);
  const vec2 high = vec2(slope.x <= 0.0 ? origin.x : kNever, slope.y <= 0.0 ? origin.y : kNever);
  frustum.reach_low = min(frustum.reach_low, member ? low - abs(low) * kFrustumPad : vec2(kNever));
  frustum.reach_high = max(frustum.reach_high, member ? high + abs(high) * kFrustumPad : vec2(-kNever));
  frustum.z_last = max(frustum.z_last, member ? reach_of(frustum, origin, scale, t_max) : -kNever);
}

// From bounds over each lane's rays to bounds over all.
void gather_frustum(inout Frustum frustum) {
  frustum.from_low = group_min(frustum.from_low);
  frustum.from_high = group_max(frustum.from_high);
  frustum.slope_low = group_min(frustum.slope_low);
  frustum.slope_high = group_max(frustum.slope_high);
  frustum.reach_low = group_min(frustum.reach_low);
  frustum.reach_high = group_max(frustum.reach_high);
  frustum.z_last = group_max(frustum.z_last) * 1.000002;
}

// Slopes are linear: the lowest ray within a stretch is lowest at one of its ends. (Comparisons and selects, because
// llvmpipe spends three instructions on a minimum for NaN.)
bool frustum_hits_box(Frustum frustum, vec3 low, vec3 high) {
  const float z0 = max((frustum.forward > 0.0 ? low.z : -high.z) - frustum.start, 0.0);
  const float z1 = (frustum.forward > 0.0 ? high.z : -low.z) - frustum.start;
  const vec2 frustum_low = frustum.from_low + frustum.slope_low * vec2(frustum.slope_low.x < 0.0 ? z1 : z0,
                                                                       frustum.slope_low.y < 0.0 ? z1 : z0);
  const vec2 frustum_high = frustum.from_high + frustum.slope_high * vec2(frustum.slope_high.x > 0.0 ? z1 : z0,
                                                                          frustum.slope_high.y > 0.0 ? z1 : z0);
  return z1 >= 0.0 && z0 <= frustum.z_last && low.x <= frustum_high.x && high.x >= frustum_low.x &&
         low.y <= frustum_high.y && high.y >= frustum_low.y && low.x <= frustum.reach_high.x &&
         high.x >= frustum.reach_low.x && low.y <= frustum.reach_high.y && high.y >= frustum.reach_low.y;
}

// The edge function of the edge from p to q, seen along the frustum's middle, and how much it can differ over the
// frustum. p and q are offsets from the middle at their depths. A ray at from + slope * z off the middle sees
//   (p - from - slope p.z) x (q - from - slope q.z), which is p x q and, since from and slope are within their half
//   widths, at most |q - p| from + |q p.z - p q.z| slope + |p.z - q.z| from slope more or less.
void bound_edge(vec3 p, vec3 q, vec2 from, vec2 slope, inout bool above, inout bool below) {
  const float u0 = p.x * q.y;
  const float u1 = p.y * q.x;
  const vec2 edge = abs(q.xy - p.xy);
  const vec2 turn = abs(q.xy * p.z - p.xy * q.z);
  const float both = from.x * slope.y + from.y * slope.x;
  const float bound = edge.x * from.y + edge.y * from.x + turn.x * slope.y + turn.y * slope.x + abs(p.z - q.z) * both +
                      (abs(u0) + abs(u1)) * kFrustumPad;
  const float u = u0 - u1;
  above = above || u > bound;
  below = below || u < -bound;
}

// Whether a ray may hit: no side of the frustum has the whole triangle behind it, and no two edges see all rays on
// different sides. A point that a ray hits lies within the sides, which are linear, so that a triangle behind one has
// no such point even where it begins before the frustum.
bool frustum_hits_triangle(Frustum frustum, Triangle s) {
  const vec2 from = (frustum.from_low + frustum.from_high) * 0.5;
  const vec2 slope = (frustum.slope_low + frustum.slope_high) * 0.5;
  const vec2 half_from = (frustum.from_high - frustum.from_low) * 0.5;
  const vec2 half_slope = (frustum.slope_high - frustum.slope_low) * 0.5;
  vec3 p = vec3(s.a.xy, s.a.z * frustum.forward - frustum.start);
  vec3 q = vec3(s.b.xy, s.b.z * frustum.forward - frustum.start);
  vec3 r = vec3(s.c.xy, s.c.z * frustum.forward - frustum.start);
  p.xy -= from + slope * p.z;
  q.xy -= from + slope * q.z;
  r.xy -= from + slope * r.z;
  bool above = false;
  bool below = false;
  bound_edge(p, q, half_from, half_slope, above, below);
  bound_edge(q, r, half_from, half_slope, above, below);
  bound_edge(r, p, half_from, half_slope, above, below);
  const vec2 p_side = half_from + half_slope * p.z;
  const vec2 q_side = half_from + half_slope * q.z;
  const vec2 r_side = half_from + half_slope * r.z;
  const bool beside = (p.x > p_side.x && q.x > q_side.x && r.x > r_side.x) ||
                      (p.y > p_side.y && q.y > q_side.y && r.y > r_side.y) ||
                      (-p.x > p_side.x && -q.x > q_side.x && -r.x > r_side.x) ||
                      (-p.y > p_side.y && -q.y > q_side.y && -r.y > r_side.y);
  const float z0 = frustum.forward > 0.0 ? s.z_low : -s.z_high;
  const float z1 = frustum.forward > 0.0 ? s.z_high : -s.z_low;
  return z1 - frustum.start >= 0.0 && z0 - frustum.start <= frustum.z_last && !beside && !(above && below);
}
