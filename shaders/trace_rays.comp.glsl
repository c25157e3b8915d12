// SPDX-License-Identifier: Apache-2.0
// Closest hits of single rays, against the proxies or the host's full detail: those that packets gave back, or all.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "bindings.glsl"
#include "trace.glsl"
layout(constant_id = 2) const uint kTraceHost = 0u;
layout(constant_id = 4) const int kRaysPerLane = 4;  // 0: there were no packets

#include "host_set.glsl"
#include "traverse.glsl"
#include "end_set.glsl"
#include "proxy_set.glsl"
#include "traverse.glsl"
#include "end_set.glsl"

layout(local_size_x = 64) in;
#include "list_index.glsl"

void main() {
  uint i = list_index();
  if (i >= (kRaysPerLane > 0 ? counters.retry_count : counters.ray_count)) return;
  if (kRaysPerLane > 0) i = retries[i];
  const RayTask task = load_ray(i);
  const TraceRay ray =
      TraceRay(vec3(task.origin_x, task.origin_y, task.origin_z), task.t_min, vec3(task.dir_x, task.dir_y, task.dir_z),
               task.t_max, vec3(task.plane_x, task.plane_y, task.plane_z));
  if (kTraceHost != 0u) {
    hits[i] = host_trace(ray, false);
  } else {
    hits[i] = proxy_trace(ray, false);
  }
}
