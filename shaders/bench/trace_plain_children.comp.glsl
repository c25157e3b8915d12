// SPDX-License-Identifier: Apache-2.0
// trace_rays.comp.glsl over the uncompressed layout, nodes by child.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "passes/bindings.glsl"
#include "traverse/trace.glsl"
#include "traverse/ray_queue.glsl"
layout(local_size_x = 64, local_size_x_id = 7) in;
#include "bench/plain_children_ray.glsl"
#include "traverse/traverse.glsl"

#include "traverse/list_index.glsl"

void main() {
  uint index;
  TraceRay ray;
  if (take_ray(list_index(), index, ray)) put_hit(index, plain_trace(ray, kAnyHit != 0u));
}
