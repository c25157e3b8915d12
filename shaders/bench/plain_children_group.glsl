// SPDX-License-Identifier: Apache-2.0
// As page_layout_group.glsl.
#include "bench/plain_children.glsl"

NodeRefs plain_load_child(uint node, uint slot, int longest, out vec3 low, out vec3 high) {
  const uvec4 a = plain_load4(node + 8u * slot);
  const uvec4 b = plain_load4(node + 8u * slot + 4u);
  const uint octant = slot ^ group_lane;
  low = permute(uintBitsToFloat(a.xyz), longest);
  high = permute(uintBitsToFloat(b.xyz), longest);
  return plain_refs(uvec4(from_lane(a.w, octant), from_lane(a.w, 1u ^ octant), from_lane(a.w, 2u ^ octant),
                          from_lane(a.w, 3u ^ octant)),
                    from_lane(a.w, 4u ^ octant));
}

plain_Cluster plain_load_group_cluster(uint error_bits) { return plain_load_cluster(error_bits); }
