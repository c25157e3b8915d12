// SPDX-License-Identifier: Apache-2.0
// The pages' trees without compression, for the traversals to be measured over (see page_layout.glsl): exact boxes in
// floats and triangles of three corners in twelve words. replay/bench/plain_layout.h writes
// it, root first, relative to the camera's lattice point.

#define PAGE_NAME(x) plain_##x
#define SET_ROOT 0u

// Of a box's far distances: two ulp are enough for (plane - origin) * reciprocal (Ize 2013, section 3).
const float kFarPad = 1.0000005;

uvec4 plain_load4(uint word) {
  return kPoolPath == kPoolTexels ? texelFetch(pool_texels4, int(word >> 2)) : pool4[word >> 2];
}

struct plain_Cluster {
  float error_m;
};

// The node has all that is left of a cluster.
plain_Cluster plain_load_cluster(uint error_bits) { return plain_Cluster(uintBitsToFloat(error_bits)); }

// Triangles are numbered from the pool's first word on.
void plain_load_triangle(plain_Cluster cluster, uint triangle, out vec3 a, out vec3 b, out vec3 c) {
  a = uintBitsToFloat(plain_load4(12u * triangle).xyz);
  b = uintBitsToFloat(plain_load4(12u * triangle + 4u).xyz);
  c = uintBitsToFloat(plain_load4(12u * triangle + 8u).xyz);
}

NodeRefs plain_refs(uvec4 words, uint error_bits) {
  return NodeRefs(words.x & 0xFFu, words.x >> 8, words.w, words.y, words.z, error_bits);
}
