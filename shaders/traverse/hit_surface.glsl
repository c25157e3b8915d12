// SPDX-License-Identifier: Apache-2.0
// What a ray hit. Needs PAGE_NAME and page_appearance.glsl. position: metres, relative to camera_lattice.

HitSurface PAGE_NAME(hit_surface)(uint triangle_word, vec3 position, float footprint_m) {
  HitSurface s;
  s.zone = PAGE_NAME(zone_at)(triangle_word);
  const PAGE_NAME(Cluster) cluster = PAGE_NAME(cluster_at)(s.zone.page_word, triangle_word);
  const uint index = triangle_word - cluster.triangle_word;
  const uint packed_triangle = PAGE_NAME(load)(triangle_word);
  vec3 a;
  vec3 b;
  vec3 c;
  PAGE_NAME(load_corners)(cluster, packed_triangle, a, b, c);
  const vec3 n = cross(b - a, c - a);
  s.geometric_normal = normalize(n);
  s.shading_normal = s.geometric_normal;
  uvec2 appearance;
  s.attributes = PAGE_NAME(material_attributes)(cluster, packed_triangle, appearance);
  const float per_metre = 1.0 / frame.step_m;
  if (PAGE_NAME(is_textured)(appearance)) {
    const float per_step = exp2(-float(cluster.shift));
    const vec3 steps = (position * per_metre - vec3(cluster.offset)) * per_step;
    s.attributes.base = PAGE_NAME(atlas_color)(PAGE_NAME(load_atlas)(cluster.page_word), appearance, steps,
                                         footprint_m * per_metre * per_step);
  }
  if ((cluster.counts & (kClusterLight | kClusterNormals)) != 0u) {
    const vec3 p = position * per_metre;
    const vec3 barycentric =
        vec3(dot(cross(c - b, p - b), n), dot(cross(a - c, p - c), n), dot(cross(b - a, p - a), n)) / dot(n, n);
    const vec3 inside = clamp(barycentric, vec3(0.0), vec3(1.0));
    if ((cluster.counts & kClusterLight) != 0u)
      add_baked_light(PAGE_NAME(load_light)(cluster, index), inside, s.attributes);
    const uvec2 normals = PAGE_NAME(load_normals)(cluster, index);
    if (normals != uvec2(0u)) s.shading_normal = corner_normal(normals, inside);
  }
  return s;
}
