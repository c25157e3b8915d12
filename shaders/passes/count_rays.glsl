// SPDX-License-Identifier: Apache-2.0
// Counters that many invocations of a subgroup raise at once take one atomic for all of them on a GPU, where they would
// wait for each other in memory. Needs bindings.glsl.
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require

// Adds the number of active invocations.
#define COUNT_RAYS(counter)                                                     \
  if (kThreadPerPixel == 0u) {                                                  \
    atomicAdd(counter, 1u);                                                     \
  } else {                                                                      \
    const uint active_count = subgroupBallotBitCount(subgroupBallot(true));     \
    if (subgroupElect()) atomicAdd(counter, active_count);                      \
  }

// Takes one place of a list for each active invocation, in the order of the lanes.
#define TAKE_PLACE(counter, place)                                                                 \
  if (kThreadPerPixel == 0u) {                                                                     \
    place = atomicAdd(counter, 1u);                                                                \
  } else {                                                                                         \
    const uvec4 active_lanes = subgroupBallot(true);                                               \
    uint first_place = 0u;                                                                         \
    if (subgroupElect()) first_place = atomicAdd(counter, subgroupBallotBitCount(active_lanes));   \
    place = subgroupBroadcastFirst(first_place) + subgroupBallotExclusiveBitCount(active_lanes);   \
  }
