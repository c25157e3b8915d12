// SPDX-License-Identifier: Apache-2.0
// What traverse_packet.glsl asks besides page_layout.glsl. Needs lane_group.glsl.

// A lane's share of a node: the box of the child in its slot, relative to the camera's lattice point, permuted. Every
// lane gets the same references.
NodeRefs PAGE_NAME(load_child)(uint node, uint slot, int longest, out vec3 low, out vec3 high) {
  // Lanes 0 to 4 fetch four words each. Lanes 5 to 7 fetch the planes once more and put those of slots 4 to 7 where the
  // others have slots 0 to 3: each lane finds the six words that its child is in by one shuffle each.
  const bool again = group_lane >= 5u;
  const uvec4 words = PAGE_NAME(load4)(node + 4u * (again ? group_lane - 3u : group_lane));
  const uint even = again ? words.y : words.x;
  const uint odd = again ? words.w : words.z;
  const uint masks = from_lane(words.w, 0u);
  const uvec3 node_origin = uvec3(from_lane(words.x, 0u), from_lane(words.y, 0u), from_lane(words.z, 0u));
  const uint planes = slot < 4u ? 2u : 5u;
  const uint shift = 8u * (slot & 3u);
  const uvec3 low_bytes = uvec3(from_lane(even, planes), from_lane(odd, planes), from_lane(even, planes + 1u));
  const uvec3 high_bytes =
      uvec3(from_lane(odd, planes + 1u), from_lane(even, planes + 2u), from_lane(odd, planes + 2u));
  const vec3 from = vec3(ivec3(node_origin) - frame.camera_lattice.xyz);
  const vec3 unit = uintBitsToFloat(((uvec3(masks, masks >> 5, masks >> 10) & 31u) + 127u) << 23);
  low = permute(from + vec3((low_bytes >> shift) & 0xFFu) * unit, longest);
  high = permute(from + vec3((high_bytes >> shift) & 0xFFu) * unit, longest);
  return NodeRefs((masks >> 16) & 0xFFu, masks >> 24, from_lane(words.z, 1u), node + from_lane(words.x, 1u),
                  node + from_lane(words.y, 1u), node + from_lane(words.w, 1u));
}

// As load_cluster, each lane fetching a word. What nobody reads of it is never shuffled.
PAGE_NAME(Cluster) PAGE_NAME(load_group_cluster)(uint word) {
  const uint mine = PAGE_NAME(load)(word + group_lane);
  return PAGE_NAME(cluster_of)(
      word, uvec4(from_lane(mine, 0u), from_lane(mine, 1u), from_lane(mine, 2u), from_lane(mine, 3u)),
      uvec4(from_lane(mine, 4u), from_lane(mine, 5u), from_lane(mine, 6u), from_lane(mine, 7u)));
}
