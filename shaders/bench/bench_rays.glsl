// SPDX-License-Identifier: Apache-2.0
// What every kernel of `zonecast bench trace` reads and writes: bindings 0 and 1; its own data starts at binding 2.
// Rays are six floats: origin, unit direction. One invocation a ray.

layout(local_size_x = 64) in;

layout(constant_id = 0) const uint kAnyHit = 0u;  // 1: a ray ends at any hit

struct BenchHit {
  float t;
  uint triangle;
};

layout(set = 0, binding = 0, std430) readonly buffer Rays { float bench_rays[]; };
layout(set = 0, binding = 1, std430) writeonly buffer Hits { BenchHit bench_hits[]; };
layout(push_constant) uniform Push { uint bench_ray_count; };

const uint kMiss = 0xFFFFFFFFu;

// More groups than one dimension takes go on in the next row.
uint bench_ray_index() { return gl_GlobalInvocationID.y * gl_NumWorkGroups.x * 64u + gl_GlobalInvocationID.x; }

vec3 bench_origin(uint ray) { return vec3(bench_rays[6u * ray], bench_rays[6u * ray + 1u], bench_rays[6u * ray + 2u]); }

vec3 bench_direction(uint ray) {
  return vec3(bench_rays[6u * ray + 3u], bench_rays[6u * ray + 4u], bench_rays[6u * ray + 5u]);
}

void bench_write(uint ray, float t, uint triangle) {
  bench_hits[ray] = BenchHit(triangle == kMiss ? uintBitsToFloat(0x7F800000u) : t, triangle);
}
