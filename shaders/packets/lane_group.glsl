// SPDX-License-Identifier: Apache-2.0
// Teams: eight neighbouring invocations of a subgroup that work on one packet of rays together. Everything is built on
// shuffles, because on llvmpipe 22.3 a shuffle is one instruction while broadcast, ballot and the arithmetic operations of
// subgroups are loops over the lanes.
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_shuffle : require

#include "packets/packet.glsl"

uint team_lane;   // 0..7
uint team_first;  // the subgroup invocation of lane 0

void begin_team() {
  team_lane = gl_SubgroupInvocationID & (kTeam - 1u);
  team_first = gl_SubgroupInvocationID - team_lane;
}

uint from_lane(uint v, uint lane) { return subgroupShuffle(v, team_first + lane); }
float from_lane(float v, uint lane) { return subgroupShuffle(v, team_first + lane); }
vec2 from_lane(vec2 v, uint lane) { return vec2(from_lane(v.x, lane), from_lane(v.y, lane)); }
vec3 from_lane(vec3 v, uint lane) { return vec3(from_lane(v.xy, lane), from_lane(v.z, lane)); }

uint other_lane(uint v, uint mask) { return subgroupShuffle(v, gl_SubgroupInvocationID ^ mask); }
float other_lane(float v, uint mask) { return subgroupShuffle(v, gl_SubgroupInvocationID ^ mask); }

uint team_min(uint v) {
  v = min(v, other_lane(v, 1u));
  v = min(v, other_lane(v, 2u));
  return min(v, other_lane(v, 4u));
}
float team_min(float v) {
  v = min(v, other_lane(v, 1u));
  v = min(v, other_lane(v, 2u));
  return min(v, other_lane(v, 4u));
}
vec2 team_min(vec2 v) { return vec2(team_min(v.x), team_min(v.y)); }
float team_max(float v) { return -team_min(-v); }
vec2 team_max(vec2 v) { return -team_min(-v); }

uint team_sum(uint v) {
  v += other_lane(v, 1u);
  v += other_lane(v, 2u);
  return v + other_lane(v, 4u);
}

uint team_or(uint v) {
  v |= other_lane(v, 1u);
  v |= other_lane(v, 2u);
  return v | other_lane(v, 4u);
}
// Bit per lane.
uint team_ballot(bool b) { return team_or(b ? 1u << team_lane : 0u); }
