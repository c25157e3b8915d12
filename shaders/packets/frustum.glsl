// SPDX-License-Identifier: Apache-2.0
// A beam: bounds over the rays of a packet that run along the same axis, against which boxes and triangles are culled.
// Sources: frustum bounds of coherent packets after Reshetov, Soupikov & Hurley 2005 ("Multi-level ray tracing
// algorithm"), bounded on the dominant axis after Wald, Ize, Kensler, Knoll & Parker 2006 (grid traversal of packets).
// Positions are permuted, the axis last. Along it z counts forward from the first origin: a ray is at from + slope * z.
// Every bound is padded by more than the roundings of the tests that it stands in for: what the beam misses, no ray hits.

struct Beam {
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

const float kBeamPad = 1e-6;

Beam empty_beam(float start, float forward) {
  return Beam(forward, start, -kNever, vec2(kNever), vec2(-kNever), vec2(kNever), vec2(-kNever), vec2(kNever), vec2(-kNever));
}

// Where along the beam a ray has come at a distance.
float reach_of(Beam beam, vec3 origin, vec3 scale, float t) {
  return origin.z * beam.forward - beam.start + t / abs(scale.z);
}

void widen_beam(inout Beam beam, bool member, vec3 origin, vec3 scale, float t_max) {
  const float ahead = origin.z * beam.forward - beam.start;
  const vec2 slope = scale.xy * beam.forward;
  const vec2 from = origin.xy - slope * ahead;
  const vec2 pad = (abs(origin.xy) + abs(slope * ahead)) * kBeamPad;
  const vec2 slope_pad = abs(slope) * kBeamPad;
  beam.from_low = min(beam.from_low, member ? from - pad : vec2(kNever));
  beam.from_high = max(beam.from_high, member ? from + pad : vec2(-kNever));
  beam.slope_low = min(beam.slope_low, member ? slope - slope_pad : vec2(kNever));
  beam.slope_high = max(beam.slope_high, member ? slope + slope_pad : vec2(-kNever));
  const vec2 low = vec2(slope.x >= 0.0 ? origin.x : -kNever, slope.y >= 0.0 ? origin.y : -kNever);
  const vec2 high = vec2(slope.x <= 0.0 ? origin.x : kNever, slope.y <= 0.0 ? origin.y : kNever);
  beam.reach_low = min(beam.reach_low, member ? low - abs(low) * kBeamPad : vec2(kNever));
  beam.reach_high = max(beam.reach_high, member ? high + abs(high) * kBeamPad : vec2(-kNever));
  beam.z_last = max(beam.z_last, member ? reach_of(beam, origin, scale, t_max) : -kNever);
}

// From bounds over each lane's rays to bounds over all.
void gather_beam(inout Beam beam) {
  beam.from_low = team_min(beam.from_low);
  beam.from_high = team_max(beam.from_high);
  beam.slope_low = team_min(beam.slope_low);
  beam.slope_high = team_max(beam.slope_high);
  beam.reach_low = team_min(beam.reach_low);
  beam.reach_high = team_max(beam.reach_high);
  beam.z_last = team_max(beam.z_last) * 1.000002;
}

// Slopes are linear: the lowest ray within a stretch is lowest at one of its ends. (Comparisons and selects, because
// llvmpipe spends three instructions on a minimum for NaN.)
bool beam_meets_box(Beam beam, vec3 low, vec3 high) {
  const float z0 = max((beam.forward > 0.0 ? low.z : -high.z) - beam.start, 0.0);
  const float z1 = (beam.forward > 0.0 ? high.z : -low.z) - beam.start;
  const vec2 beam_low =
      beam.from_low + beam.slope_low * vec2(beam.slope_low.x < 0.0 ? z1 : z0, beam.slope_low.y < 0.0 ? z1 : z0);
  const vec2 beam_high =
      beam.from_high + beam.slope_high * vec2(beam.slope_high.x > 0.0 ? z1 : z0, beam.slope_high.y > 0.0 ? z1 : z0);
  return z1 >= 0.0 && z0 <= beam.z_last && low.x <= beam_high.x && high.x >= beam_low.x && low.y <= beam_high.y &&
         high.y >= beam_low.y && low.x <= beam.reach_high.x && high.x >= beam.reach_low.x && low.y <= beam.reach_high.y &&
         high.y >= beam.reach_low.y;
}

// The edge function of the edge from p to q, seen along the beam's middle, and how much it can differ over the beam. p and
// q are offsets from the middle at their depths. A ray at from + slope * z off the middle sees
//   (p - from - slope p.z) x (q - from - slope q.z), which is p x q and, since from and slope are within their half widths,
//   at most |q - p| from + |q p.z - p q.z| slope + |p.z - q.z| from slope more or less.
void bound_edge(vec3 p, vec3 q, vec2 from, vec2 slope, inout bool above, inout bool below) {
  const float u0 = p.x * q.y;
  const float u1 = p.y * q.x;
  const vec2 edge = abs(q.xy - p.xy);
  const vec2 turn = abs(q.xy * p.z - p.xy * q.z);
  const float both = from.x * slope.y + from.y * slope.x;
  const float bound = edge.x * from.y + edge.y * from.x + turn.x * slope.y + turn.y * slope.x + abs(p.z - q.z) * both +
                      (abs(u0) + abs(u1)) * kBeamPad;
  const float u = u0 - u1;
  above = above || u > bound;
  below = below || u < -bound;
}

// Whether a ray may hit: no side of the beam has the whole triangle behind it, and no two edges see all rays on different
// sides. A point that a ray meets lies within the sides, which are linear, so that a triangle behind one has no such point
// even where it begins before the beam.
bool beam_meets_triangle(Beam beam, Triangle s) {
  const vec2 from = (beam.from_low + beam.from_high) * 0.5;
  const vec2 slope = (beam.slope_low + beam.slope_high) * 0.5;
  const vec2 half_from = (beam.from_high - beam.from_low) * 0.5;
  const vec2 half_slope = (beam.slope_high - beam.slope_low) * 0.5;
  vec3 p = vec3(s.a.xy, s.a.z * beam.forward - beam.start);
  vec3 q = vec3(s.b.xy, s.b.z * beam.forward - beam.start);
  vec3 r = vec3(s.c.xy, s.c.z * beam.forward - beam.start);
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
  const float z0 = beam.forward > 0.0 ? s.z_low : -s.z_high;
  const float z1 = beam.forward > 0.0 ? s.z_high : -s.z_low;
  return z1 - beam.start >= 0.0 && z0 - beam.start <= beam.z_last && !beside && !(above && below);
}
