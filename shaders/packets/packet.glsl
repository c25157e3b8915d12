// SPDX-License-Identifier: Apache-2.0
// What makes a packet; see traverse_packet.glsl.
#ifndef ZC_SHADERS_PACKET
#define ZC_SHADERS_PACKET

const uint kLaneGroup = 8u;            // invocations that work on one
const float kGroupCosine = 0.99;  // between the directions of rays that go together
const uint kGroupLeast = 3u;      // rays
const uint kStepsPerRay = 3u;  // nodes and batches of triangles: where a group takes more, its rays fare better alone
const float kNever = 1e30;

#endif
