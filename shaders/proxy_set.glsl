// SPDX-License-Identifier: Apache-2.0
// Traversal of the resident proxies: trace → proxy_trace, and so on.
#define PAGE_NAME(x) proxy_##x
#define POOL proxy_pool
#define ZONES proxy_zones
#define TOP proxy_top
#include "traverse.glsl"
#undef PAGE_NAME
#undef POOL
#undef ZONES
#undef TOP
