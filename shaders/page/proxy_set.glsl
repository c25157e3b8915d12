// SPDX-License-Identifier: Apache-2.0
// The resident proxies: defines what page_fetch.glsl and the traversals take. Undo with end_set.glsl.
#define PAGE_NAME(x) proxy_##x
#define POOL proxy_pool
#define POOL4 proxy_pool4
#define TEXELS proxy_texels
#define TEXELS4 proxy_texels4
#define ZONES proxy_zones
#define SET_ROOT frame.sets.x
#define SET_ZONES frame.sets.y
#define SET_END frame.set_ends.x
