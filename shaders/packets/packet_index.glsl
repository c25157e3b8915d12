// SPDX-License-Identifier: Apache-2.0
// Which packet a lane group has; as list_index.glsl, to be included where the size of groups is known.

uint packet_index() {
  const uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
  return (group * gl_WorkGroupSize.x + gl_SubgroupID * gl_SubgroupSize + group_first) / kLaneGroup;
}
