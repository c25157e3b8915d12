// SPDX-License-Identifier: Apache-2.0
// As page_layout_team.glsl.
#include "plain_children.glsl"

NodeRefs plain_load_child(uint node, int longest, out vec3 low, out vec3 high) {
  const uvec4 a = plain_load4(node + 8u * team_lane);
  const uvec4 b = plain_load4(node + 8u * team_lane + 4u);
  low = permute(uintBitsToFloat(a.xyz), longest);
  high = permute(uintBitsToFloat(b.xyz), longest);
  return plain_refs(uvec4(from_lane(a.w, 0u), from_lane(a.w, 1u), from_lane(a.w, 2u), from_lane(a.w, 3u)),
                    from_lane(a.w, 4u));
}
