// SPDX-License-Identifier: Apache-2.0
// Which entry of a list an invocation of a dispatch sized by size_dispatch.comp.glsl has; the last row ends beyond it.

uint list_index() {
  return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
}
