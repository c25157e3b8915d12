// SPDX-License-Identifier: Apache-2.0
// Counters that many invocations of a subgroup raise at once take one atomic for all of them: one at a time, they wait
// for each other in memory.
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require

// Adds the number of active invocations.
#define COUNT_RAYS(counter)                                      \
  {                                                              \
    const uvec4 active_lanes = subgroupBallot(true);             \
    const uint active_count = subgroupBallotBitCount(active_lanes); \
    if (subgroupElect()) atomicAdd(counter, active_count);       \
  }

// Takes one place of a list for each active invocation, in the order of the lanes.
#define TAKE_PLACE(counter, place)                                   \
  {                                                                  \
    const uvec4 active_lanes = subgroupBallot(true);                 \
    uint first_place = 0u;                                           \
    if (subgroupElect()) first_place = atomicAdd(counter, subgroupBallotBitCount(active_lanes)); \
    place = subgroupBroadcastFirst(first_place) + subgroupBallotExclusiveBitCount(active_lanes); \
  }
