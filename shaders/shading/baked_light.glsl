// SPDX-License-Identifier: Apache-2.0
// What a page's TriangleLight says for the sun that shines now. Needs shading.glsl.

// The bake's sun shines; see kSunUnknown.
bool sun_is_baked() { return frame.sun_is_baked != 0u; }

// At a point with these barycentric coordinates.
void add_baked_light(uvec2 light, vec3 barycentric, inout SurfaceAttributes attributes) {
  const uint around_bits = light.y & 0xFFFFu;
  const vec3 around = vec3(float(around_bits >> 11), float(around_bits >> 5 & 63u) * (31.0 / 63.0),
                           float(around_bits & 31u)) / 31.0;
  attributes.sky = dot(unpackUnorm4x8(light.x).xyz, barycentric);
  const float varies = float(light.x >> 24) / 255.0;
  const float mean = float(light.y >> 16 & 63u) / 63.0;
  const vec3 most = unfold_octahedron(vec2(light.y >> 24 & 15u, light.y >> 28) / 7.5 - 1.0);
  const float share = max(mean + varies * dot(most, frame.sun_direction.xyz), 0.0);
  // What hides the sky is lit by about half of it.
  attributes.bounce =
      around * (frame.sun_radiance.xyz * share + 0.5 * (1.0 - attributes.sky) * sky_irradiance(vec3(0.0)));
  attributes.sun = sun_is_baked() ? light.y >> 22 & 3u : kSunUnknown;
}
