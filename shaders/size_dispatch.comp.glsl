// SPDX-License-Identifier: Apache-2.0
// Turns the counts of the pixel and ray lists into indirect arguments, 64 invocations a group, in rows of at most
// 65,535 groups: more in one dimension is not for every device. See list_index.glsl.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "bindings.glsl"

layout(local_size_x = 1) in;

const uint kRow = 65535u;

void main() {
  const uint ssr_groups = (counters.pixel_count + 63u) / 64u;
  counters.ssr_groups_x = min(ssr_groups, kRow);
  counters.ssr_groups_y = (ssr_groups + kRow - 1u) / kRow;
  counters.ssr_groups_z = 1u;
  const uint trace_groups = (counters.ray_count + 63u) / 64u;
  counters.trace_groups_x = min(trace_groups, kRow);
  counters.trace_groups_y = (trace_groups + kRow - 1u) / kRow;
  counters.trace_groups_z = 1u;
}
