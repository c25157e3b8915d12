// SPDX-License-Identifier: Apache-2.0
// The host's full-detail zones: defines what page_fetch.glsl and the traversals take. Undo with end_set.glsl.
#define PAGE_NAME(x) host_##x
#define POOL host_pool
#define POOL4 host_pool4
#define TEXELS host_texels
#define TEXELS4 host_texels4
#define ZONES host_zones
#define SET_ROOT frame.sets.z
#define SET_ZONES frame.sets.w
#define SET_END frame.set_ends.y
