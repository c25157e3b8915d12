// SPDX-License-Identifier: Apache-2.0
// Closest hits of the queued rays in packets, against the proxies or the host's full detail; see traverse_packet.glsl.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "bindings.glsl"
#include "trace.glsl"
#include "team.glsl"
#include "beam.glsl"
layout(constant_id = 2) const uint kTraceHost = 0u;
layout(constant_id = 4) const int kRaysPerLane = 4;
const uint kStackPairs = (uint(kStackSize) + kTeam - 1u) / kTeam;  // of registers a lane

#include "host_set.glsl"
#include "page_fetch.glsl"
#include "traverse_packet.glsl"
#include "end_set.glsl"
#include "proxy_set.glsl"
#include "page_fetch.glsl"
#include "traverse_packet.glsl"
#include "end_set.glsl"

layout(local_size_x = 64, local_size_x_id = 7) in;

void main() {
  begin_team();
  const uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
  const uint lane = group * gl_WorkGroupSize.x + gl_SubgroupID * gl_SubgroupSize + team_first;
  const uint first_ray = lane * uint(kRaysPerLane);
  if (first_ray >= counters.ray_count) return;
  if (kTraceHost != 0u) {
    host_trace_packet(first_ray);
  } else {
    proxy_trace_packet(first_ray);
  }
}
