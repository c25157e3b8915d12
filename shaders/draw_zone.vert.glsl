// SPDX-License-Identifier: Apache-2.0
// The host's G-buffer: pulls a zone's triangles straight from its page; one draw a zone, the slot is the instance.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "scene_bindings.glsl"
#include "octahedral.glsl"

#include "host_set.glsl"
#include "page_fetch.glsl"

layout(location = 0) flat out uvec2 out_surface;

void main() {
  const uint triangle = gl_VertexIndex / 3;
  const uint corner = gl_VertexIndex % 3;
  const ZoneEntry zone = host_zones[gl_InstanceIndex];
  vec3 a;
  vec3 b;
  vec3 c;
  uint material;
  host_fetch_triangle(zone.page_word, triangle, a, b, c, material);
  const vec3 n = cross(b - a, c - a);
  const float l = length(n);
  const vec3 p = (corner == 0u ? a : (corner == 1u ? b : c)) * frame.sun_radiance.w;
  gl_Position = frame.view_projection * vec4(p, 1.0);
  out_surface = uvec2(pack_normal(l > 0.0 ? n / l : vec3(0, 0, 1)), material);
}
