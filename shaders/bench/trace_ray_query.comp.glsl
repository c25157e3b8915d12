// SPDX-License-Identifier: Apache-2.0
// The driver's own ray query.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_ray_query : require
#include "bench/bench_rays.glsl"

layout(set = 0, binding = 2) uniform accelerationStructureEXT scene;

void main() {
  const uint ray = bench_ray_index();
  if (ray >= bench_ray_count) return;
  const uint flags = gl_RayFlagsOpaqueEXT | (kAnyHit != 0u ? gl_RayFlagsTerminateOnFirstHitEXT : gl_RayFlagsNoneEXT);
  rayQueryEXT query;
  rayQueryInitializeEXT(query, scene, flags, 0xFFu, bench_origin(ray), 0.0, bench_direction(ray),
                        3.4028235e38);
  while (rayQueryProceedEXT(query)) {
  }
  const bool hit = rayQueryGetIntersectionTypeEXT(query, true) == gl_RayQueryCommittedIntersectionTriangleEXT;
  bench_write(ray, hit ? rayQueryGetIntersectionTEXT(query, true) : 0.0,
              hit ? uint(rayQueryGetIntersectionPrimitiveIndexEXT(query, true)) : kMiss);
}
