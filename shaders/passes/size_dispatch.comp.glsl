// SPDX-License-Identifier: Apache-2.0
// Turns the counts of the pixel, ray and fallback lists into indirect arguments, in rows of at most 65,535 groups: more
// in one dimension is not for every device. See list_index.glsl.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "passes/bindings.glsl"

layout(local_size_x = 1) in;

#include "packets/packet.glsl"

const uint kRow = 65535u;
const uint kPassWidth = 64u;  // invocations a group of the passes that are not specialised

layout(constant_id = 4) const int kRaysPerLane = 4;
layout(constant_id = 7) const uint kTraceWidth = 64u;

uvec3 groups_of(uint invocations, uint width) {
  const uint groups = (invocations + width - 1u) / width;
  return uvec3(min(groups, kRow), (groups + kRow - 1u) / kRow, 1u);
}

void main() {
  const uvec3 ssr = groups_of(counters.pixel_count, kPassWidth);
  counters.ssr_groups_x = ssr.x;
  counters.ssr_groups_y = ssr.y;
  counters.ssr_groups_z = ssr.z;
  const uvec3 trace = groups_of(counters.ray_count, kPassWidth);
  counters.trace_groups_x = trace.x;
  counters.trace_groups_y = trace.y;
  counters.trace_groups_z = trace.z;
  const uint rays_per_lane = uint(max(kRaysPerLane, 1));
  const uvec3 packets = groups_of((counters.ray_count + rays_per_lane - 1u) / rays_per_lane, kTraceWidth);
  counters.packet_groups_x = packets.x;
  counters.packet_groups_y = packets.y;
  counters.packet_groups_z = packets.z;
  const uvec3 fallback_rays = groups_of(
      kRaysPerLane > 0 ? counters.fallback_count * kLaneGroup * rays_per_lane : counters.ray_count, kTraceWidth);
  counters.fallback_groups_x = fallback_rays.x;
  counters.fallback_groups_y = fallback_rays.y;
  counters.fallback_groups_z = fallback_rays.z;
}
