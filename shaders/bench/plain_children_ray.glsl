// SPDX-License-Identifier: Apache-2.0
// Single rays over the nodes of packets: child by child.
#include "bench/plain_children.glsl"

uint plain_hit_children(uint node, vec3 origin, vec3 reciprocal, bvec3 backward, float t_min, float t_max,
                        out NodeRefs refs) {
  const vec3 far_reciprocal = reciprocal * kFarPad;
  const int least = floatBitsToInt(t_min);
  const int most = floatBitsToInt(t_max);
  uvec4 words;
  uint error_bits;
  uint hits = 0u;
  for (uint i = 0u; i < kNodeWidth; ++i) {
    const uvec4 a = plain_load4(node + 8u * i);
    const uvec4 b = plain_load4(node + 8u * i + 4u);
    if (i < 4u) words[i] = a.w;
    if (i == 4u) error_bits = a.w;
    const vec3 low = uintBitsToFloat(a.xyz);
    const vec3 high = uintBitsToFloat(b.xyz);
    const ivec3 near = floatBitsToInt((mix(low, high, backward) - origin) * reciprocal);
    const ivec3 far = floatBitsToInt((mix(high, low, backward) - origin) * far_reciprocal);
    const int enter = max(max(near.x, near.y), max(near.z, least));
    const int leave = min(min(far.x, far.y), min(far.z, most));
    hits |= enter <= leave ? 1u << i : 0u;
  }
  refs = plain_refs(words, error_bits);
  return hits;
}
