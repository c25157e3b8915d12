// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "passes/zone_bindings.glsl"
#include "shading/surface_attributes.glsl"
#include "adapter/sky.glsl"
#include "shading/shading.glsl"
#include "shading/baked_light.glsl"

#include "page/zone_set.glsl"
#include "page/page_fetch.glsl"
#include "page/page_appearance.glsl"

layout(location = 0) in vec3 in_steps;
layout(location = 1) in vec2 in_barycentric;
layout(location = 2) flat in uvec4 in_surface;
layout(location = 3) flat in uvec4 in_appearance;
layout(location = 4) flat in uvec2 in_normals;
layout(location = 5) flat in float in_texels_per_step;
layout(location = 0) out uvec4 surface;

void main() {
  const vec3 barycentric = vec3(in_barycentric, 1.0 - in_barycentric.x - in_barycentric.y);
  const vec3 across = max(abs(dFdx(in_steps)), abs(dFdy(in_steps)));
  SurfaceAttributes attributes = unpack_attributes(in_surface.y, 0u, kSunUnknown);
  add_baked_light(in_surface.zw, barycentric, attributes);
  uint base = in_surface.y;
  if (page_is_textured(in_appearance.xy)) {
    const page_Atlas atlas = page_Atlas(in_appearance.z, in_appearance.w, in_texels_per_step);
    const vec3 color = page_atlas_color(atlas, in_appearance.xy, in_steps, max(across.x, max(across.y, across.z)));
    base = (base & 0xFF000000u) | packUnorm4x8(vec4(srgb_of_linear(color), 0.0));
  }
  const uint shading_normal = in_normals == uvec2(0u) ? 0u : pack_normal_30(corner_normal(in_normals, barycentric));
  surface =
      uvec4(in_surface.x, base, pack_light(attributes.sky, attributes.bounce), attributes.sun | shading_normal << 2);
}
