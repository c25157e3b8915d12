// SPDX-License-Identifier: Apache-2.0
// Closest hits of single rays, against the proxies or the host's full detail: those that packets gave back, or all.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "bindings.glsl"
#include "trace.glsl"
#include "packet.glsl"
layout(local_size_x = 64, local_size_x_id = 7) in;
layout(constant_id = 2) const uint kTraceHost = 0u;
layout(constant_id = 4) const int kRaysPerLane = 4;  // 0: there were no packets

#include "host_set.glsl"
#include "traverse.glsl"
#include "end_set.glsl"
#include "proxy_set.glsl"
#include "traverse.glsl"
#include "end_set.glsl"

#include "list_index.glsl"

void main() {
  uint i = list_index();
  if (kRaysPerLane > 0) {
    const uint packet = kTeam * uint(kRaysPerLane);
    const uint place = i % packet;
    if (i / packet >= counters.retry_count) return;
    const Retry retry = retries[i / packet];
    const uint lane = place % kTeam;
    const uint mask = lane < 4u ? retry.mask_low : retry.mask_high;
    if ((mask >> (8u * (lane & 3u) + place / kTeam) & 1u) == 0u) return;
    i = retry.first_ray + place;
  } else if (i >= counters.ray_count) {
    return;
  }
  const RayTask task = load_ray(i);
  const TraceRay ray = TraceRay(vec3(task.origin_x, task.origin_y, task.origin_z), task.t_min,
                                vec3(task.dir_x, task.dir_y, task.dir_z), frame.forward.w, task.leaves);
  TraceHit hit;
  if (kTraceHost != 0u) {
    hit = host_trace(ray, false);
  } else {
    hit = proxy_trace(ray, false);
  }
  hits[i].t = hit.t;
  hits[i].triangle = hit.triangle;
}
