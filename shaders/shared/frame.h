// SPDX-License-Identifier: Apache-2.0
// Per-frame data: what a pass reads about the camera and the light, the ray queue between passes, and the one
// descriptor set layout that all passes share.
#ifndef ZC_SHADERS_SHARED_FRAME_H
#define ZC_SHADERS_SHARED_FRAME_H

#include "shared.h"

ZC_SHARED_BEGIN

#ifdef __cplusplus
struct alignas(16) vec4 {
  float x = 0, y = 0, z = 0, w = 0;
};
struct alignas(16) ivec4 {
  std::int32_t x = 0, y = 0, z = 0, w = 0;
};
struct alignas(16) uvec4 {
  std::uint32_t x = 0, y = 0, z = 0, w = 0;
};
struct mat4 {
  vec4 column[4];
};
#endif

// Descriptor set 0: a number for each thing that shaders bind. A program's layout has those that its shaders use, at
// most 16 storage buffers in a stage.
ZC_CONST(uint, kBindFrame, 0u);
ZC_CONST(uint, kBindPool, 1u);   // the pages of the zones that are traced or drawn
ZC_CONST(uint, kBindPool4, 2u);  // the same pool, four words at a time
ZC_CONST(uint, kBindPoolTexels, 3u);
ZC_CONST(uint, kBindPoolTexels4, 4u);
ZC_CONST(uint, kBindZones, 5u);
ZC_CONST(uint, kBindMaterials, 6u);
ZC_CONST(uint, kBindHiz, 7u);          // float: nearest depth per cell, all levels
ZC_CONST(uint, kBindProvenance, 8u);   // uint a pixel
ZC_CONST(uint, kBindPixels, 9u);       // uint: reflective pixels
ZC_CONST(uint, kBindRays, 10u);        // RayTask
ZC_CONST(uint, kBindRayTexels4, 11u);  // the ray queue, as texels of four words
ZC_CONST(uint, kBindHits, 12u);        // HitRecord, or ResolvedHit
ZC_CONST(uint, kBindFallbackRays, 13u);
ZC_CONST(uint, kBindCounters, 14u);
// What a host fills (adapter/load_surface.glsl) and what it gets.
ZC_CONST(uint, kBindDepth, 15u);       // sampled: reversed-Z depth
ZC_CONST(uint, kBindSurface, 16u);     // sampled: normals and material
ZC_CONST(uint, kBindIrradiance, 17u);  // sampled: rgb of the irradiance; of the sky its radiance
ZC_CONST(uint, kBindReflection,
         18u);  // written: rgb of the mirrored radiance; alpha 1 where a ray was followed, else 0
// Of the stand-in host alone.
ZC_CONST(uint, kBindIrradianceOut, 19u);
ZC_CONST(uint, kBindReflectionIn, 20u);
ZC_CONST(uint, kBindOutput, 21u);  // uint a pixel: RGBA8 sRGB
// Pools and rays as texel buffers too: on some drivers a fetch is several times faster than a load from a storage
// buffer (measured: Mesa 22.3 lavapipe, 2.4 times for a whole traversal).

ZC_CONST(uint, kHizLevels, 12u);

// How shaders read the pools and the ray queue; a specialisation constant.
ZC_CONST(uint, kPoolTexels, 0u);
ZC_CONST(uint, kPoolStorage, 1u);

struct HizLevel {
  uint first;  // of its floats
  uint width;
  uint height;
  uint reserved;
};

struct FrameData {
  mat4 view_projection;  // metres from camera_lattice -> clip, reversed Z, infinite far
  vec4 eye;              // metres from camera_lattice; w of this and the next is not used
  vec4 right;            // unit
  vec4 up;               // unit
  vec4 forward;          // unit
  vec4 sun_direction;    // unit, towards the sun
  vec4 sun_radiance;
  ivec4 camera_lattice;  // lattice position that all positions are relative to
  float near_m;
  float tan_half_fov_x;
  float tan_half_fov_y;
  float ray_length_m;      // of the longest ray
  float step_m;            // of the lattice
  float roughness_cut;     // rougher surfaces do not mirror
  uint sun_is_baked;       // 1: the sun is the one that the pages' light was baked for
  uint screen_step_limit;  // of a ray's march through the depth buffer
  uint width;
  uint height;
  uint hiz_level_count;
  uint reserved;
  uint root_word;  // of the top level, in the pool
  uint zone_count;
  uint end_word;  // the first word behind the top level
  uint reserved1;
  HizLevel hiz_levels[kHizLevels];
};

// Small, because a packet reads sixty-four: the pixel that a ray is for waits in its HitRecord, and all are equally
// long.
struct RayTask {
  float origin_x;  // metres, relative to camera_lattice
  float origin_y;
  float origin_z;
  float t_min;
  float dir_x;  // unit
  float dir_y;
  float dir_z;
  uint origin_normal;  // normal, as wound, of the surface that the ray leaves (octahedral.glsl), or kNoSurface: every
                       // hit counts
};
ZC_CONST(uint, kNoSurface, 0x80008000u);  // no normal is packed so

// In place of a word of the pool.
ZC_CONST(uint, kHitNone, 0xFFFFFFFFu);
ZC_CONST(uint, kHitLost, 0xFFFFFFFEu);  // the traversal's bound was reached: always counted

struct HitRecord {
  float t;             // metres; undefined where nothing was hit
  uint triangle_word;  // the triangle's own word in the pool, or kHitNone / kHitLost
  uint pixel;          // that asked
};

// What resolve_hits.comp.glsl leaves in a HitRecord's place.
struct ResolvedHit {
  float t;         // as it was
  uint page_word;  // the page's first word in the pool, or kHitNone / kHitLost
  uint triangle;   // its position in that page; undefined where nothing was hit
};

// Rays that packets left to fallback rays: bit 8 * (lane % 4) + r of mask lane / 4 stands for ray first_ray + 8 * r +
// lane.
struct FallbackRays {
  uint first_ray;
  uint mask_low;
  uint mask_high;
};

struct Counters {
  uint ssr_groups_x;  // indirect arguments of the SSR pass
  uint ssr_groups_y;
  uint ssr_groups_z;
  uint trace_groups_x;  // and of trace and shade
  uint trace_groups_y;
  uint trace_groups_z;
  uint pixel_count;
  uint ray_count;
  uint rays_screen;
  uint rays_proxy;
  uint rays_proxy_coarse;
  uint rays_sky;
  uint rays_lost;
  uint fallback_count;
  uint packet_groups_x;  // indirect arguments of the packet trace
  uint packet_groups_y;
  uint packet_groups_z;
  uint fallback_groups_x;  // and of the rays that packets left to fallback rays
  uint fallback_groups_y;
  uint fallback_groups_z;
  uint out_of_page;  // words asked for outside the pages and the top level; counted only with kCheckAccess
};

// Where a pixel's reflected colour came from; the zone's node index lies above kSourceBits.
ZC_CONST(uint, kSourceNone, 0u);
ZC_CONST(uint, kSourceScreen, 1u);
ZC_CONST(uint, kSourceProxy, 2u);
ZC_CONST(uint, kSourceProxyCoarse, 3u);
ZC_CONST(uint, kSourceSky, 4u);
ZC_CONST(uint, kSourceLost, 5u);
ZC_CONST(uint, kSourceBits, 3u);

struct PassConstants {
  uint a;
  uint b;
  uint c;
  uint d;
};

ZC_CONST(uint, kDebugProvenance, 1u);
ZC_CONST(uint, kDebugNormals, 2u);
ZC_CONST(uint, kDebugDepth, 3u);

ZC_SHARED_END

#ifdef __cplusplus
static_assert(sizeof(zc::gpu::RayTask) == 32);
static_assert(sizeof(zc::gpu::HitRecord) == 12);
static_assert(sizeof(zc::gpu::ResolvedHit) == sizeof(zc::gpu::HitRecord));
static_assert(sizeof(zc::gpu::FallbackRays) == 12);
static_assert(sizeof(zc::gpu::Counters) == 84);
static_assert(sizeof(zc::gpu::FrameData) == 64 + 11 * 16 + 16 * zc::gpu::kHizLevels);
#endif

#endif
