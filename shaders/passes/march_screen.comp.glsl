// SPDX-License-Identifier: Apache-2.0
// Screen-space reflections by Hi-Z traversal (Uludag 2014, "Hi-Z Screen-Space Cone-Traced Reflections", GPU Pro 5),
// with one difference: there is no thickness constant. A crossing counts as a hit where the ray intersects the tangent
// plane of the pixel's surface within that pixel, or next to it on the same plane; else the ray went behind something:
// *occluded*. Every ray ends as hit, sky, occluded, off-screen or exhausted; the last three go on against the proxies
// from the last point that was verified free.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "passes/bindings.glsl"
#include "adapter/load_surface.glsl"
#include "adapter/sky.glsl"
#include "passes/count_rays.glsl"
#include "shading/shading.glsl"

layout(local_size_x = 64) in;
#include "traverse/list_index.glsl"
layout(constant_id = 1) const uint kUseScreen = 1u;

const uint kHit = 0u;
const uint kSky = 1u;
const uint kUnknown = 2u;  // occluded, off-screen or exhausted

struct March {
  uint end;
  ivec2 pixel;
  float t;  // metres: of the hit, or up to which the ray is known to be free
};

// Pixel coordinates and reversed depth: all three are linear along a ray's image.
vec3 project(vec3 from_eye) {
  const float z = dot(from_eye, frame.forward.xyz);
  const vec2 ndc = vec2(dot(from_eye, frame.right.xyz) / (z * frame.tan_half_fov_x),
                        -dot(from_eye, frame.up.xyz) / (z * frame.tan_half_fov_y));
  return vec3((ndc * 0.5 + 0.5) * vec2(frame_size()), frame.near_m / z);
}

float hiz_at(uint level, uvec2 cell) {
  const HizLevel at = frame.hiz_levels[level];
  return hiz[at.first + cell.y * at.width + cell.x];
}

// Whether the pixel that the ray came from shows the same plane: then the crossing may lie between the two pixels'
// centres. At an outline it does not, and a ray that passes behind the outline must not be caught by it.
bool same_plane(Surface h, vec2 from, float footprint_m) {
  const Surface before = load_surface(clamp(ivec2(from), ivec2(0), ivec2(frame_size()) - 1));
  return !before.sky && dot(before.normal, h.normal) > 0.9 &&
         abs(dot(before.position - h.position, h.normal)) <= footprint_m;
}

March march_screen(Surface s, vec3 direction) {
  March result = March(kUnknown, ivec2(0), 0.0);
  const vec3 from_eye = s.position - frame.eye.xyz;
  const float z0 = dot(from_eye, frame.forward.xyz);
  const float dz = dot(direction, frame.forward.xyz);
  float length_m = frame.ray_length_m;
  bool toward_eye = false;
  if (z0 + dz * length_m < frame.near_m * 1.01) {
    length_m = (z0 - frame.near_m * 1.01) / -dz;
    toward_eye = true;
  }
  if (length_m <= 0.0) return result;
  const vec3 p0 = project(from_eye);
  const vec3 p1 = project(from_eye + direction * length_m);
  const vec3 delta = p1 - p0;
  const float reach = max(abs(delta.x), abs(delta.y));
  if (reach < 0.01) return result;  // along the view: the screen shows nothing of it

  const vec2 reciprocal = vec2(abs(delta.x) > 1e-6 ? 1.0 / delta.x : 1e30, abs(delta.y) > 1e-6 ? 1.0 / delta.y : 1e30);
  const vec2 forward_side = vec2(delta.x > 0.0 ? 1.0 : 0.0, delta.y > 0.0 ? 1.0 : 0.0);
  const vec2 border = (forward_side * vec2(frame_size()) - p0.xy) * reciprocal;
  const float s_border = min(abs(delta.x) > 1e-6 ? border.x : 1e30, abs(delta.y) > 1e-6 ? border.y : 1e30);
  const float s_end = min(1.0, s_border);
  const float nudge = 0.002 / reach;
  const float k0 = 1.0 / z0;
  const float k1 = p1.z / frame.near_m;
  const uint top_level = frame.hiz_level_count - 1u;

  uint level = 0u;
  float at = 0.0;
  bool first = true;
  for (uint i = 0u; i < frame.screen_step_limit && at < s_end; ++i) {
    const vec2 here = p0.xy + delta.xy * (at + nudge);
    const uvec2 cell = uvec2(clamp(ivec2(here), ivec2(0), ivec2(frame_size()) - 1)) >> level;
    const vec2 edge = (vec2(cell) + forward_side) * float(1u << level);
    const vec2 out_at = (edge - p0.xy) * reciprocal;
    const float leave = min(min(abs(delta.x) > 1e-6 ? out_at.x : 1e30, abs(delta.y) > 1e-6 ? out_at.y : 1e30), s_end);
    const float beyond = max(leave, at + nudge);
    const float z_in = p0.z + delta.z * at;
    const float z_out = p0.z + delta.z * beyond;
    bool free = first;  // the pixel that the ray leaves
    if (!free) free = min(z_in, z_out) > hiz_at(level, cell);
    if (!free && level == 0u) {
      const Surface h = load_surface(ivec2(cell));
      const float footprint_m = pixel_footprint_m(h.distance_m);
      const bool own = abs(dot(h.position - s.position, s.normal)) <= footprint_m + 1e-5 * h.distance_m &&
                       dot(h.normal, s.normal) > 0.9;
      if (own) {
        free = true;
      } else {
        const float facing = dot(direction, h.normal);
        const float t = dot(h.position - s.position, h.normal) / min(facing, -1e-6);
        const vec2 meet = project(from_eye + direction * t).xy;
        const vec2 off = abs(meet - (vec2(cell) + 0.5));
        const float pixels_off = max(off.x, off.y);
        if (!h.sky && facing < 0.0 && t > 0.0 && z0 + dz * t > frame.near_m && pixels_off <= 1.5 &&
            (pixels_off <= 0.55 || same_plane(h, p0.xy + delta.xy * (at - nudge), footprint_m))) {
          result.end = kHit;
          result.pixel = ivec2(cell);
          result.t = t;
        }
        return result;
      }
    } else if (!free) {
      --level;
      continue;
    }
    at = beyond;
    result.t = length_m * at * k1 / (k0 * (1.0 - at) + k1 * at);
    if (!first) level = min(level + 1u, top_level);
    first = false;
  }
  if (at >= 1.0 && !toward_eye) result.end = kSky;
  return result;
}

void main() {
  const uint i = list_index();
  if (i >= counters.pixel_count) return;
  const uint index = pixels[i];
  const ivec2 pixel = ivec2(index % frame.width, index / frame.width);
  const Surface s = load_surface(pixel);
  const vec3 direction = mirrored_direction(s);

  March march = March(kUnknown, ivec2(0), 0.0);
  if (kUseScreen != 0u) march = march_screen(s, direction);
  if (march.end == kHit) {
    const Surface h = load_surface(march.pixel);
    const vec3 light = texelFetch(irradiance_image, march.pixel, 0).rgb;
    const vec3 normal = dot(h.shading_normal, direction) < 0.0 ? h.shading_normal : h.normal;
    imageStore(reflection_image, pixel,
               pack_radiance(shade_mirrored(h.attributes, normal, direction, light, march.t), 1.0));
    provenance[index] = kSourceScreen;
    COUNT_RAYS(counters.rays_screen);
  } else if (march.end == kSky) {
    imageStore(reflection_image, pixel, pack_radiance(sky_radiance(direction), 1.0));
    provenance[index] = kSourceSky;
    COUNT_RAYS(counters.rays_sky);
  } else {
    const float start_m = 1e-3 + 1e-5 * s.distance_m;
    const vec3 origin = s.position + s.normal * start_m;
    // Where no ray ends on the screen, the queue is the list of pixels, tile by tile.
    uint taken;
    TAKE_PLACE(counters.ray_count, taken);
    const uint ray = kUseScreen != 0u ? taken : i;
    rays[ray] =
        RayTask(origin.x, origin.y, origin.z, march.t * 0.998, direction.x, direction.y, direction.z, s.origin_normal);
    hits[ray].pixel = index;
  }
}
