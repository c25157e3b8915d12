// SPDX-License-Identifier: Apache-2.0
// What a surface looks like, whoever asks: the G-buffer, a hit on the screen or a hit on a proxy; and how the G-buffer
// packs it.

#include "page/octahedral.glsl"

struct SurfaceAttributes {
  vec3 base;  // linear
  float roughness;
  float metallic;
  float sky;    // share of the sky's diffuse light that arrives, 0..1
  vec3 bounce;  // irradiance that other surfaces send, on the scale of frame.sun_radiance
  uint sun;     // kSunLit or kSunShadow where the bake settled it for this sun, else kSunUnknown
};

// Of sRGB, within 0.2 % (a cubic fit), so that eight bits come back as they were.
vec3 linear_of_srgb(vec3 c) { return c * (c * (c * 0.305306011 + 0.682171111) + 0.012522878); }
// Its inverse on the fit's range, by two Newton steps from the square root.
vec3 srgb_of_linear(vec3 linear) {
  vec3 c = sqrt(clamp(linear, 0.0, 1.0));
  for (int i = 0; i < 2; ++i)
    c -= (linear_of_srgb(c) - linear) / (c * (c * 0.915918033 + 1.364342222) + 0.012522878);
  return clamp(c, 0.0, 1.0);
}

vec3 rgb_of_565(uint c) {
  return vec3(float(c >> 11 & 31u) / 31.0, float(c >> 5 & 63u) / 63.0, float(c & 31u) / 31.0);
}

// Base colour in sRGB, 8 bits each; from bit 24 the square root of the roughness (6 bits), so that mirrors stay apart;
// from bit 30 metalness (2 bits).
uint pack_base(vec3 base, float roughness, float metallic) {
  return packUnorm4x8(vec4(srgb_of_linear(base), 0.0)) | uint(sqrt(roughness) * 63.0 + 0.5) << 24 |
         uint(metallic * 3.0 + 0.5) << 30;
}

// On the colour of a page's Appearance.
float appearance_gain(uvec2 appearance) { return exp2(-float(appearance.x >> 23 & 255u) / 32.0); }

// Sky share, then the square root of half the bounced light: 8 bits each.
uint pack_light(float sky, vec3 bounce) { return packUnorm4x8(vec4(sqrt(clamp(bounce * 0.5, 0.0, 1.0)), sky)); }

SurfaceAttributes unpack_attributes(uint base, uint light, uint sun) {
  SurfaceAttributes attributes;
  attributes.base = linear_of_srgb(unpackUnorm4x8(base).rgb);
  const float root = float(base >> 24 & 63u) / 63.0;
  attributes.roughness = root * root;
  attributes.metallic = float(base >> 30) / 3.0;
  const vec4 l = unpackUnorm4x8(light);
  attributes.bounce = 2.0 * l.rgb * l.rgb;
  attributes.sky = l.a;
  attributes.sun = sun;
  return attributes;
}
