// SPDX-License-Identifier: Apache-2.0
// Nodes by child: eight words each, its lower corner, a word, its upper corner, a word. The first words of the first
// four children are the references, that of the fifth the zone's error.
#include "bench/plain_layout.glsl"

const uint plain_node_words = 64u;
