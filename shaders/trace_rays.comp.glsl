// SPDX-License-Identifier: Apache-2.0
// Closest hits of the queued rays: against the proxies, or against the host's full detail.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "bindings.glsl"
#include "trace.glsl"
layout(constant_id = 2) const uint kTraceHost = 0u;
#include "host_set.glsl"
#include "proxy_set.glsl"

layout(local_size_x = 64) in;
#include "list_index.glsl"

void main() {
  const uint i = list_index();
  if (i >= counters.ray_count) return;
  const RayTask task = rays[i];
  const TraceRay ray =
      TraceRay(vec3(task.origin_x, task.origin_y, task.origin_z), task.t_min, vec3(task.dir_x, task.dir_y, task.dir_z),
               task.t_max, vec3(task.plane_x, task.plane_y, task.plane_z));
  if (kTraceHost != 0u) {
    hits[i] = host_trace(ray, false);
  } else {
    hits[i] = proxy_trace(ray, false);
  }
}
