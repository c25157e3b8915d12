// SPDX-License-Identifier: Apache-2.0
// Lane groups: eight neighbouring invocations of a subgroup that work on one packet of rays together. Everything is
// built on shuffles, because on llvmpipe 22.3 a shuffle is one instruction while broadcast, ballot and the arithmetic
// operations of subgroups are loops over the lanes.
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_shuffle : require

#include "packets/packet.glsl"

uint group_lane;   // 0..7
uint group_first;  // the subgroup invocation of lane 0

void begin_group() {
  group_lane = gl_SubgroupInvocationID & (kLaneGroup - 1u);
  group_first = gl_SubgroupInvocationID - group_lane;
}

uint from_lane(uint v, uint lane) { return subgroupShuffle(v, group_first + lane); }
float from_lane(float v, uint lane) { return subgroupShuffle(v, group_first + lane); }
vec2 from_lane(vec2 v, uint lane) { return vec2(from_lane(v.x, lane), from_lane(v.y, lane)); }
vec3 from_lane(vec3 v, uint lane) { return vec3(from_lane(v.xy, lane), from_lane(v.z, lane)); }

uint other_lane(uint v, uint mask) { return subgroupShuffle(v, gl_SubgroupInvocationID ^ mask); }
float other_lane(float v, uint mask) { return subgroupShuffle(v, gl_SubgroupInvocationID ^ mask); }

uint group_min(uint v) {
  v = min(v, other_lane(v, 1u));
  v = min(v, other_lane(v, 2u));
  return min(v, other_lane(v, 4u));
}
float group_min(float v) {
  v = min(v, other_lane(v, 1u));
  v = min(v, other_lane(v, 2u));
  return min(v, other_lane(v, 4u));
}
vec2 group_min(vec2 v) { return vec2(group_min(v.x), group_min(v.y)); }
float group_max(float v) { return -group_min(-v); }
vec2 group_max(vec2 v) { return -group_min(-v); }

uint group_sum(uint v) {
  v += other_lane(v, 1u);
  v += other_lane(v, 2u);
  return v + other_lane(v, 4u);
}

uint group_or(uint v) {
  v |= other_lane(v, 1u);
  v |= other_lane(v, 2u);
  return v | other_lane(v, 4u);
}
// Bit per lane.
uint group_ballot(bool b) { return group_or(b ? 1u << group_lane : 0u); }
