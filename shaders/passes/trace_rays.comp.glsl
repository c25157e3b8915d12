// SPDX-License-Identifier: Apache-2.0
// Closest or any hits of single rays: those that packets left to fallback rays, or all.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "passes/bindings.glsl"
#include "traverse/trace.glsl"
#include "traverse/ray_queue.glsl"
layout(local_size_x = 64, local_size_x_id = 7) in;

#include "page/zone_set.glsl"
#include "page/page_layout.glsl"
#include "traverse/traverse.glsl"
#include "page/end_set.glsl"

#include "traverse/list_index.glsl"

void main() {
  uint index;
  TraceRay ray;
  if (!take_ray(list_index(), index, ray)) return;
  put_hit(index, page_trace(ray, kAnyHit != 0u));
}
