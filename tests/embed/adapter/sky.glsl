// SPDX-License-Identifier: Apache-2.0
// This host's sky: one colour, that the city is seen against.
vec3 sky_radiance(vec3 direction) { return vec3(0.0, 0.0, 4.0); }
vec3 sky_irradiance(vec3 normal) { return vec3(0.5); }
