// SPDX-License-Identifier: Apache-2.0
// The host's G-buffer, by rays: a mirror for a floor, 2 m below the eye, and a red box that stands on it 20 m ahead.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.h"
#include "shading/surface_attributes.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0, std140) uniform FrameBlock { FrameData frame; };
layout(set = 0, binding = 1, r32f) uniform writeonly image2D depth;
layout(set = 0, binding = 2, rgba32ui) uniform writeonly uimage2D surface;
layout(set = 0, binding = 3, rgba16f) uniform writeonly image2D irradiance;

void main() {
  const ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  const vec2 ndc = (vec2(pixel) + 0.5) / vec2(frame.width, frame.height) * 2.0 - 1.0;
  // So long that it comes 1 m along the view.
  const vec3 ray = frame.forward.xyz + frame.right.xyz * (ndc.x * frame.tan_half_fov_x) -
                   frame.up.xyz * (ndc.y * frame.tan_half_fov_y);
  const vec3 ahead = normalize(vec3(frame.forward.xy, 0.0));
  const float box_m = 20.0 / max(dot(ray, ahead), 1e-6);
  const vec3 at_box = ray * box_m;
  const float floor_m = ray.z < 0.0 ? -2.0 / ray.z : 1e9;
  const bool box = abs(dot(at_box, frame.right.xyz)) < 3.0 && at_box.z > -2.0 && at_box.z < 3.0;
  const bool mirror = !box && floor_m < 60.0;
  const uint normal = pack_normal(box ? -ahead : vec3(0, 0, 1));
  const uint material = box ? pack_base(vec3(0.8, 0.05, 0.05), 1.0, 0.0) : pack_base(vec3(0.9), 0.0, 1.0);
  imageStore(depth, pixel, vec4(box ? frame.near_m / box_m : mirror ? frame.near_m / floor_m : 0.0));
  imageStore(surface, pixel, uvec4(normal, material, 0u, 0u));
  imageStore(irradiance, pixel, vec4(1.0));
}
