// SPDX-License-Identifier: Apache-2.0
// Adds the mirrored light to the lit surfaces, tone-maps (Narkowicz 2015, ACES fit) and writes sRGB.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "host/host_bindings.glsl"
#include "adapter/load_surface.glsl"
#include "adapter/sky.glsl"
#include "shading/shading.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

void main() {
  const ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, ivec2(frame_size())))) return;
  const uint index = uint(pixel.y) * frame.width + uint(pixel.x);
  const Surface s = load_surface(pixel);
  vec3 color = texelFetch(irradiance_image, pixel, 0).rgb;
  if (!s.sky) {
    // Without a traced ray the surface mirrors the sky if it mirrors at all (--reflections none).
    const Shading shading = shade_surface(s.attributes, s.shading_normal, s.view);
    const vec4 reflected = texelFetch(reflection_in, pixel, 0);
    const vec3 mirrored = reflected.a > 0.0 ? reflected.rgb : sky_radiance(mirrored_direction(s));
    color = add_haze(color * shading.diffuse + shading.specular * mirrored, s.view, s.distance_m);
  }
  color *= 0.9;
  color = clamp((color * (2.51 * color + 0.03)) / (color * (2.43 * color + 0.59) + 0.14), 0.0, 1.0);
  color = mix(12.92 * color, 1.055 * pow(color, vec3(1.0 / 2.4)) - 0.055, greaterThan(color, vec3(0.0031308)));
  output_rgba[index] = packUnorm4x8(vec4(color, 1.0));
}
