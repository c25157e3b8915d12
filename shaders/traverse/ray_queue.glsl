// SPDX-License-Identifier: Apache-2.0
// The queue as the kernels of trace_rays.comp.glsl and trace_packets.comp.glsl take rays from it.

#include "packets/packet.glsl"
layout(constant_id = 4) const int kRaysPerLane = 4;  // of packets; 0: there are none
layout(constant_id = 8) const uint kAnyHit = 0u;      // 1: rays end at any hit

// An invocation's ray among those that packets left to fallback rays, or among all. False: none is left for it.
bool take_ray(uint place, out uint index, out TraceRay ray) {
  index = place;
  if (kRaysPerLane > 0) {
    const uint packet = kLaneGroup * uint(kRaysPerLane);
    const uint in_packet = place % packet;
    if (place / packet >= counters.fallback_count) return false;
    const FallbackRays entry = fallback_rays[place / packet];
    const uint lane = in_packet % kLaneGroup;
    const uint mask = lane < 4u ? entry.mask_low : entry.mask_high;
    if ((mask >> (8u * (lane & 3u) + in_packet / kLaneGroup) & 1u) == 0u) return false;
    index = entry.first_ray + in_packet;
  } else if (place >= counters.ray_count) {
    return false;
  }
  const RayTask task = load_ray(index);
  ray = TraceRay(vec3(task.origin_x, task.origin_y, task.origin_z), task.t_min,
                 vec3(task.dir_x, task.dir_y, task.dir_z), frame.ray_length_m, task.origin_normal);
  return true;
}

void put_hit(uint index, TraceHit hit) {
  hits[index].t = hit.t;
  hits[index].triangle_word = hit.triangle_word;
}
