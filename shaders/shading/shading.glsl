// SPDX-License-Identifier: Apache-2.0
// The one shading function: primary surfaces, screen hits and proxy hits all go through it, so that no seam shows where
// one kind of hit ends and the next begins (the thesis's visible colour change). Needs surface_attributes.glsl.

float hash_lattice(vec2 p) { return fract(sin(dot(p, vec2(127.1, 311.7))) * 43758.5453); }

float value_noise(vec2 p) {
  const vec2 cell = floor(p);
  const vec2 f = fract(p);
  const vec2 u = f * f * (3.0 - 2.0 * f);
  return mix(mix(hash_lattice(cell), hash_lattice(cell + vec2(1, 0)), u.x),
             mix(hash_lattice(cell + vec2(0, 1)), hash_lattice(cell + vec2(1, 1)), u.x), u.y);
}

// Radiance of the sky: a clear gradient, a warm glow round the sun, thin clouds. Below the horizon: haze.
vec3 sky_radiance(vec3 d) {
  const float height = max(d.z, 0.0);
  const vec3 horizon = vec3(0.78, 0.84, 0.90);
  const vec3 zenith = vec3(0.16, 0.33, 0.66);
  vec3 color = mix(horizon, zenith, pow(height, 0.45));
  const float toward_sun = max(dot(d, frame.sun_direction.xyz), 0.0);
  if (d.z > 0.02) {
    const vec2 p = d.xy / (d.z + 0.15) * 1.7;
    const float cover = 0.55 * value_noise(p) + 0.30 * value_noise(p * 2.3 + 7.1) + 0.15 * value_noise(p * 5.1 + 3.7);
    const float cloud = smoothstep(0.48, 0.78, cover) * smoothstep(0.02, 0.25, d.z);
    color = mix(color, vec3(1.0, 0.98, 0.95), 0.75 * cloud);
  }
  const float glow = 0.25 * pow(toward_sun, 12.0);
  const float disc = 12.0 * smoothstep(0.99985, 0.99995, toward_sun);
  color += (glow + disc) * vec3(1.0, 0.85, 0.65);
  return mix(vec3(0.42, 0.44, 0.46), color, smoothstep(-0.12, 0.0, d.z));  // the lower edge first, or it is undefined
}

// Share of a material's specular light that reads as a mirror image; rough surfaces keep only diffuse light.
float mirror_share(float roughness) {
  const float cut = frame.sun_direction.w;
  return 1.0 - smoothstep(0.4 * cut, cut, roughness);
}

// Diffuse skylight on a surface that sees its whole half of the sky and ground; a zero normal: the mean.
vec3 sky_irradiance(vec3 normal) {
  return mix(vec3(0.22, 0.21, 0.20), vec3(0.42, 0.50, 0.62), 0.5 + 0.5 * normal.z);
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
