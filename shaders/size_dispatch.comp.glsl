// SPDX-License-Identifier: Apache-2.0
// Turns the counts of the pixel and ray lists into indirect arguments, 64 invocations a group.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "bindings.glsl"

layout(local_size_x = 1) in;

void main() {
  counters.ssr_groups_x = (counters.pixel_count + 63u) / 64u;
  counters.ssr_groups_y = 1u;
  counters.ssr_groups_z = 1u;
  counters.trace_groups_x = (counters.ray_count + 63u) / 64u;
  counters.trace_groups_y = 1u;
  counters.trace_groups_z = 1u;
}
