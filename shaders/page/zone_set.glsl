// SPDX-License-Identifier: Apache-2.0
// The zones that are bound: defines what page_fetch.glsl and the traversals take. Undo with end_set.glsl.
#define PAGE_NAME(x) page_##x
#define POOL pool
#define POOL4 pool4
#define TEXELS pool_texels
#define TEXELS4 pool_texels4
#define ZONES zones
#define SET_ROOT frame.root_word
#define SET_ZONES frame.zone_count
#define SET_END frame.end_word
