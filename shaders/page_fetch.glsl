// SPDX-License-Identifier: Apache-2.0
// Reading a page: vertices and boxes come out as exact floats in lattice units relative to the camera's lattice point.
// Needs POOL: the buffer's name. Exact because |q + offset| stays below 2^24 steps near the camera.

ivec3 PAGE_NAME(zone_offset)(ZoneEntry zone) {
  return ivec3(zone.origin_x, zone.origin_y, zone.origin_z) - frame.camera_lattice.xyz;
}

void PAGE_NAME(fetch_triangle)(ZoneEntry zone, ivec3 offset, uint triangle, out vec3 a, out vec3 b, out vec3 c,
                               out uint material) {
  const uint base = zone.page_word + POOL[zone.page_word + 4u] + triangle * kPageTriangleWords;
  const uint w0 = POOL[base];
  const uint w1 = POOL[base + 1u];
  const uint w2 = POOL[base + 2u];
  const uint w3 = POOL[base + 3u];
  const uint w4 = POOL[base + 4u];
  const int shift = int(zone.step_shift);
  a = vec3((ivec3(w0 & 0xFFFFu, w0 >> 16, w1 & 0xFFFFu) << shift) + offset);
  b = vec3((ivec3(w1 >> 16, w2 & 0xFFFFu, w2 >> 16) << shift) + offset);
  c = vec3((ivec3(w3 & 0xFFFFu, w3 >> 16, w4 & 0xFFFFu) << shift) + offset);
  material = w4 >> 16;
}
