// SPDX-License-Identifier: Apache-2.0
// Pictures of intermediate data in place of the frame. pass_constants.a = kDebug…
#version 460
#extension GL_GOOGLE_include_directive : require
#include "host/host_bindings.glsl"
#include "adapter/load_surface.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

// Where the reflected colour came from: screen green, proxy blue (a shade a zone), coarse proxy orange, sky light grey,
// lost red; surfaces that do not mirror stay dark, lit faintly by their normal.
vec3 provenance_color(uint bits, Surface s) {
  const uint source = bits & ((1u << kSourceBits) - 1u);
  const float shade = 0.65 + 0.35 * fract(float(bits >> kSourceBits) * 0.618034);
  if (source == kSourceScreen) return vec3(0.25, 0.75, 0.30);
  if (source == kSourceProxy) return vec3(0.15, 0.40, 0.95) * shade;
  if (source == kSourceProxyCoarse) return vec3(0.95, 0.55, 0.10) * shade;
  if (source == kSourceSky) return vec3(0.80, 0.82, 0.85);
  if (source == kSourceLost) return vec3(1.0, 0.0, 0.0);
  return s.sky ? vec3(0.02) : vec3(0.10 + 0.10 * max(dot(s.normal, normalize(vec3(0.4, -0.5, 0.8))), 0.0));
}

void main() {
  const ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, ivec2(frame_size())))) return;
  const uint index = uint(pixel.y) * frame.width + uint(pixel.x);
  const Surface s = load_surface(pixel);
  vec3 color = vec3(0.0);
  if (pass_constants.a == kDebugProvenance) {
    color = provenance_color(provenance[index], s);
  } else if (pass_constants.a == kDebugNormals) {
    color = s.sky ? vec3(0.0) : s.normal * 0.5 + 0.5;
  } else if (pass_constants.a == kDebugDepth) {
    color = s.sky ? vec3(0.0) : vec3(1.0 / (1.0 + s.distance_m / 25.0));
  }
  output_rgba[index] = packUnorm4x8(vec4(color, 1.0));
}
