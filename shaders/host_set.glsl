// SPDX-License-Identifier: Apache-2.0
// Traversal of the host's full-detail zones: trace → host_trace, and so on.
#define PAGE_NAME(x) host_##x
#define POOL host_pool
#define ZONES host_zones
#define TOP host_top
#include "traverse.glsl"
#undef PAGE_NAME
#undef POOL
#undef ZONES
#undef TOP
