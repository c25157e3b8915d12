// SPDX-License-Identifier: Apache-2.0
// The host's sky, as rays that hit nothing see it: a host with another one replaces this file. Units: radiance on the
// scale of frame.sun_radiance.

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

// Diffuse skylight on a surface that sees its whole half of the sky and ground; a zero normal: the mean.
vec3 sky_irradiance(vec3 normal) {
  return mix(vec3(0.22, 0.21, 0.20), vec3(0.42, 0.50, 0.62), 0.5 + 0.5 * normal.z);
}
