// SPDX-License-Identifier: Apache-2.0
// Closest or any hits of the queued rays in packets; see traverse_packet.glsl.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "passes/bindings.glsl"
#include "traverse/trace.glsl"
#include "packets/lane_group.glsl"
#include "packets/frustum.glsl"
#include "traverse/ray_queue.glsl"
#include "packets/packet_rays.glsl"

#include "page/zone_set.glsl"
#include "page/page_layout.glsl"
#include "page/page_layout_group.glsl"
#include "packets/traverse_packet.glsl"
#include "page/end_set.glsl"

layout(local_size_x = 64, local_size_x_id = 7) in;
#include "packets/packet_index.glsl"

void main() {
  begin_group();
  const uint first_ray = packet_index() * kLaneGroup * uint(kRaysPerLane);
  if (first_ray >= counters.ray_count) return;
  page_trace_packet(first_ray);
}
