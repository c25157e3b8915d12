// SPDX-License-Identifier: Apache-2.0
// How a pixel of the host's G-buffer becomes a position, normals and a material. A host whose G-buffer is another one
// replaces this file, or fills these images: `depth_image`, reversed Z with the far plane at infinity, 0 for the sky;
// `surface_image`, RGBA32UI: x the geometric normal (pack_normal), y base colour, roughness and metalness (pack_base),
// w, from bit 2 on, the shading normal (pack_normal_30) or 0 where it is the geometric one. z and the low bits of w are
// the stand-in host's own.

#include "shading/surface_attributes.glsl"

// Direction through a point of the image, in pixels; not normalised: its component along `forward` is 1.
vec3 view_direction(vec2 pixel) {
  const vec2 ndc = pixel / vec2(frame_size()) * 2.0 - 1.0;
  return frame.forward.xyz + frame.right.xyz * (ndc.x * frame.tan_half_fov_x) -
         frame.up.xyz * (ndc.y * frame.tan_half_fov_y);
}

struct Surface {
  bool sky;
  vec3 position;  // metres, relative to camera_lattice
  vec3 normal;    // unit, towards the viewer
  vec3 geometric_normal;   // unit, as the model winds the face
  vec3 shading_normal;  // unit, towards the viewer: the normal of the curved surface that the face stands in for, if it
                        // does
  uint origin_normal;  // geometric_normal, packed: as in RayTask
  vec3 view;      // unit, from the eye to the surface
  float distance_m;  // along the view axis
  SurfaceAttributes attributes;
};

Surface load_surface(ivec2 pixel) {
  Surface s;
  const vec3 direction = view_direction(vec2(pixel) + 0.5);
  const float depth = texelFetch(depth_image, pixel, 0).x;
  s.view = normalize(direction);
  s.sky = depth <= 0.0;
  s.distance_m = frame.near_m / max(depth, 1e-12);
  s.position = frame.eye.xyz + direction * s.distance_m;
  const uvec4 packed_surface = texelFetch(surface_image, pixel, 0);
  s.origin_normal = packed_surface.x;
  s.geometric_normal = unpack_normal(packed_surface.x);
  s.normal = dot(s.geometric_normal, s.view) > 0.0 ? -s.geometric_normal : s.geometric_normal;
  s.attributes = unpack_attributes(packed_surface.y, packed_surface.z, packed_surface.w & 3u);
  s.shading_normal = packed_surface.w >> 2 == 0u ? s.normal : unpack_normal_30(packed_surface.w >> 2);
  if (dot(s.shading_normal, s.view) > 0.0)
    s.shading_normal = normalize(s.shading_normal - 2.0 * dot(s.shading_normal, s.view) * s.view);
  return s;
}

// Where a mirror sends what the viewer sees; never into the face.
vec3 mirrored_direction(Surface s) {
  const vec3 d = reflect(s.view, s.shading_normal);
  const float below = dot(d, s.normal);
  return below > 0.0 ? d : normalize(d + (1e-3 - below) * s.normal);
}

// The width of a pixel at a distance along the view axis, in metres.
float pixel_footprint_m(float distance_m) { return 2.0 * frame.tan_half_fov_y * distance_m / float(frame.height); }
