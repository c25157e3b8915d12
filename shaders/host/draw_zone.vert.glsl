// SPDX-License-Identifier: Apache-2.0
// The stand-in host's G-buffer: pulls a zone's triangles straight from its page; one draw a zone, the slot is the
// instance.
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

layout(location = 0) out vec3 out_steps;  // from the zone's origin, in its own steps
layout(location = 1) out vec2 out_barycentric;
layout(location = 2) flat out uvec4 out_surface;  // normal, base, light
layout(location = 3) flat out uvec4 out_appearance;     // the Appearance; the atlas's first word and size
layout(location = 4) flat out uvec2 out_normals;
layout(location = 5) flat out float out_texels_per_step;

void main() {
  const uint triangle = gl_VertexIndex / 3;
  const uint corner = gl_VertexIndex % 3;
  const ZoneEntry zone = zones[gl_InstanceIndex];
  const page_Cluster cluster = page_find_cluster(zone.page_word, triangle);
  const uint index = triangle - cluster.first_triangle;
  const uint packed_triangle = page_load(cluster.triangle_word + index);
  vec3 a;
  vec3 b;
  vec3 c;
  page_load_corners(cluster, packed_triangle, a, b, c);
  const vec3 n = cross(b - a, c - a);
  const float l = length(n);
  const vec3 p = corner == 0u ? a : (corner == 1u ? b : c);
  gl_Position = frame.view_projection * vec4(p * frame.step_m, 1.0);
  out_steps = (p - vec3(cluster.offset)) * exp2(-float(cluster.shift));
  out_barycentric = vec2(corner == 0u, corner == 1u);
  uvec2 appearance;
  const SurfaceAttributes material = page_material_attributes(cluster, packed_triangle, appearance);
  const uvec2 light = page_load_light(cluster, index);
  out_surface = uvec4(pack_normal(l > 0.0 ? n / l : vec3(0, 0, 1)),
                      pack_base(material.base, material.roughness, material.metallic), light);
  out_normals = page_load_normals(cluster, index);
  out_appearance = uvec4(appearance, 0u, 0u);
  out_texels_per_step = 0.0;
  if (page_is_textured(appearance)) {
    const page_Atlas atlas = page_load_atlas(cluster.page_word);
    out_appearance.zw = uvec2(atlas.word, atlas.size);
    out_texels_per_step = atlas.texels_per_step;
  }
}
