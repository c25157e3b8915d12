// SPDX-License-Identifier: Apache-2.0
// Keeps every processor of a device busy for a while: chains of multiplications and additions, nothing read.
#version 460
layout(local_size_x = 64) in;
layout(push_constant) uniform Push { uint rounds; };
layout(set = 0, binding = 0, std430) buffer Sums { float sums[]; };

void main() {
  float x = float(gl_GlobalInvocationID.x);
  for (uint i = 0u; i < rounds; ++i) x = x * 0.999 + 0.5;
  if (x < 0.0) sums[0] = x;  // never, but the compiler cannot know
}
