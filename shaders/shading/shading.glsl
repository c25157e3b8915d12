// SPDX-License-Identifier: Apache-2.0
// The one shading function: primary surfaces, screen hits and proxy hits all go through it, so that no seam shows where
// one kind of hit ends and the next begins (the thesis's visible colour change). Needs surface_attributes.glsl and
// adapter/sky.glsl.

// Share of a material's specular light that reads as a mirror image; rough surfaces keep only diffuse light.
float mirror_share(float roughness) {
  const float cut = frame.roughness_cut;
  return 1.0 - smoothstep(0.4 * cut, cut, roughness);
}

// All diffuse light on a surface. sun_visibility in 0..1.
vec3 irradiance(SurfaceAttributes attributes, vec3 normal, float sun_visibility) {
  const float sun = max(dot(normal, frame.sun_direction.xyz), 0.0) * sun_visibility;
  return frame.sun_radiance.xyz * sun + sky_irradiance(normal) * attributes.sky + attributes.bounce;
}

struct Shading {
  vec3 diffuse;   // factor on the irradiance
  vec3 specular;  // factor on the mirrored radiance
};

// direction: unit, towards the surface.
Shading shade_surface(SurfaceAttributes attributes, vec3 normal, vec3 direction) {
  const float cosine = clamp(-dot(normal, direction), 0.0, 1.0);
  const vec3 f0 = mix(vec3(0.04), attributes.base, attributes.metallic);
  const vec3 fresnel = f0 + (1.0 - f0) * pow(1.0 - cosine, 5.0);
  const float share = mirror_share(attributes.roughness);
  Shading s;
  s.specular = fresnel * share;
  // A metal too rough to mirror still answers light: its base colour then acts as albedo.
  const vec3 albedo = attributes.base * mix(1.0, 1.0 - share, attributes.metallic);
  s.diffuse = albedo * (1.0 - fresnel * share);
  return s;
}

vec3 add_haze(vec3 color, vec3 direction, float distance_m) {
  const float clear = exp(-distance_m / 5000.0);
  return mix(vec3(0.70, 0.77, 0.84), color, clear);
}

// A surface met by a mirrored ray: what it mirrors in turn is the sky.
vec3 shade_mirrored(SurfaceAttributes attributes, vec3 normal, vec3 direction, vec3 light, float distance_m) {
  const Shading s = shade_surface(attributes, normal, direction);
  const vec3 color = s.diffuse * light + s.specular * sky_radiance(reflect(direction, normal));
  return add_haze(color, direction, distance_m);
}
