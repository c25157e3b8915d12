// SPDX-License-Identifier: Apache-2.0
// Nodes for single rays: references, then lower x of slots 0-3 and 4-7, y, z, then upper, then the zone's error. A ray
// fetches the planes that it crosses first and last, four children at a time.
#include "bench/plain_layout.glsl"

const uint plain_node_words = 56u;

// As hit_four, over planes as they are.
uint plain_hit_four(uint near_word_x, uint near_word_y, uint near_word_z, uint far_word_x, uint far_word_y,
                    uint far_word_z, vec3 origin, vec3 reciprocal, float t_min, float t_max) {
  const vec3 far_reciprocal = reciprocal * kFarPad;
  const ivec4 x0 = floatBitsToInt((uintBitsToFloat(plain_load4(near_word_x)) - origin.x) * reciprocal.x);
  const ivec4 y0 = floatBitsToInt((uintBitsToFloat(plain_load4(near_word_y)) - origin.y) * reciprocal.y);
  const ivec4 z0 = floatBitsToInt((uintBitsToFloat(plain_load4(near_word_z)) - origin.z) * reciprocal.z);
  const ivec4 x1 = floatBitsToInt((uintBitsToFloat(plain_load4(far_word_x)) - origin.x) * far_reciprocal.x);
  const ivec4 y1 = floatBitsToInt((uintBitsToFloat(plain_load4(far_word_y)) - origin.y) * far_reciprocal.y);
  const ivec4 z1 = floatBitsToInt((uintBitsToFloat(plain_load4(far_word_z)) - origin.z) * far_reciprocal.z);
  const ivec4 enter = max(max(x0, y0), max(z0, ivec4(floatBitsToInt(t_min))));
  const ivec4 leave = min(min(x1, y1), min(z1, ivec4(floatBitsToInt(t_max))));
  uint hits = 0u;
  for (int i = 0; i < 4; ++i) hits |= enter[i] <= leave[i] ? 1u << i : 0u;
  return hits;
}

uint plain_hit_children(uint node, vec3 origin, vec3 reciprocal, bvec3 backward, float t_min, float t_max,
                        out NodeRefs refs) {
  refs = plain_refs(plain_load4(node), plain_load4(node + 52u).x);
  const uvec3 near = node + 4u + uvec3(backward.x ? 24u : 0u, backward.y ? 32u : 8u, backward.z ? 40u : 16u);
  const uvec3 far = node + 4u + uvec3(backward.x ? 0u : 24u, backward.y ? 8u : 32u, backward.z ? 16u : 40u);
  return plain_hit_four(near.x, near.y, near.z, far.x, far.y, far.z, origin, reciprocal, t_min, t_max) |
         plain_hit_four(near.x + 4u, near.y + 4u, near.z + 4u, far.x + 4u, far.y + 4u, far.z + 4u, origin, reciprocal,
                        t_min, t_max)
             << 4;
}
