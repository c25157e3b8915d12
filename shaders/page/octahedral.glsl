// SPDX-License-Identifier: Apache-2.0
// Octahedral unit vectors (Cigolle et al. 2014, section 2), 16 bits a component.
#ifndef ZC_SHADERS_OCTAHEDRAL
#define ZC_SHADERS_OCTAHEDRAL

uint pack_normal(vec3 n) {
  n /= abs(n.x) + abs(n.y) + abs(n.z);
  vec2 p = n.xy;
  if (n.z < 0.0) p = (1.0 - abs(n.yx)) * vec2(n.x >= 0.0 ? 1.0 : -1.0, n.y >= 0.0 ? 1.0 : -1.0);
  return packSnorm2x16(p);
}

vec3 unfold_octahedron(vec2 p) {
  vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
  if (n.z < 0.0) n.xy = (1.0 - abs(n.yx)) * vec2(n.x >= 0.0 ? 1.0 : -1.0, n.y >= 0.0 ? 1.0 : -1.0);
  return normalize(n);
}

vec3 unpack_normal(uint bits) { return unfold_octahedron(unpackSnorm2x16(bits)); }

// In 30 bits, never 0: 0 stands for none.
uint pack_normal_30(vec3 n) {
  const uint bits = pack_normal(n);
  return max((bits & 0xFFFFu) >> 1 | (bits >> 17) << 15, 1u);
}
vec3 unpack_normal_30(uint bits) { return unpack_normal((bits & 0x7FFFu) << 1 | (bits >> 15) << 17); }

// TriangleNormals: the unit normal between the corners.
vec3 corner_normal(uvec2 normals, vec3 barycentric) {
  const vec2 a = vec2(normals.x & 1023u, normals.x >> 10 & 1023u);
  const vec2 b = vec2(normals.x >> 20 & 1023u, normals.y & 1023u);
  const vec2 c = vec2(normals.y >> 10 & 1023u, normals.y >> 20 & 1023u);
  return normalize(unfold_octahedron(a / 511.5 - 1.0) * barycentric.x +
                   unfold_octahedron(b / 511.5 - 1.0) * barycentric.y +
                   unfold_octahedron(c / 511.5 - 1.0) * barycentric.z);
}

#endif
