// SPDX-License-Identifier: Apache-2.0
// How a triangle of a page looks at a point. Needs PAGE_NAME and page_fetch.glsl, surface_attributes.glsl,
// baked_light.glsl and the materials.

// A BC1 texel, sRGB.
vec3 PAGE_NAME(block_texel)(uint block_word, uint x, uint y) {
  const uint ends = PAGE_NAME(load)(block_word);
  const uint index = PAGE_NAME(load)(block_word + 1u) >> (2u * (4u * y + x)) & 3u;
  const vec3 first = rgb_of_565(ends & 0xFFFFu);
  const vec3 second = rgb_of_565(ends >> 16);
  const bool four = (ends & 0xFFFFu) > ends >> 16;
  if (index < 2u) return index == 0u ? first : second;
  if (!four) return index == 2u ? 0.5 * (first + second) : vec3(0.0);
  return mix(first, second, index == 2u ? 1.0 / 3.0 : 2.0 / 3.0);
}

// An atlas as its page's header has it: first word in the pool, size, texels a step.
struct PAGE_NAME(Atlas) {
  uint word;
  uint size;
  float texels_per_step;
};

PAGE_NAME(Atlas) PAGE_NAME(load_atlas)(uint page_word) {
  const uint at = page_word + kPageAtlasWord;
  return PAGE_NAME(Atlas)(page_word + PAGE_NAME(load)(at), PAGE_NAME(load)(at + 1u),
                          uintBitsToFloat(PAGE_NAME(load)(at + 2u)));
}

// Linear, filtered over four texels of the level whose texels are about as wide as the footprint. `steps`: the point in
// the zone's own steps from its origin; the footprint likewise.
vec3 PAGE_NAME(atlas_color)(PAGE_NAME(Atlas) atlas, uvec2 appearance, vec3 steps, float footprint) {
  const uint axis = appearance.x >> 18 & 3u;
  const float scale = atlas.texels_per_step * exp2(-float(appearance.x >> 20 & 7u));
  const vec2 moved = vec2(float(int(appearance.y << 16) >> 16), float(int(appearance.y) >> 16));
  const vec2 texel = (axis == 0u ? steps.yz : (axis == 1u ? steps.xz : steps.xy)) * scale + moved;
  const int levels = int(atlas.size >> 16);
  const int level = clamp(int(log2(max(footprint * scale, 1.0)) + 0.5), 0, levels - 1);
  const uvec2 size_log2 = uvec2(atlas.size & 255u, atlas.size >> 8 & 255u);
  uint word = atlas.word;
  for (int l = 0; l < level; ++l) word += 2u << (size_log2.x + size_log2.y - 4u - 2u * uint(l));
  const uvec2 size = uvec2(1u) << (size_log2 - uint(level));
  const vec2 at = clamp(texel * exp2(-float(level)) - 0.5, vec2(0.0), vec2(size) - 1.0);
  const uvec2 low = uvec2(at);
  const vec2 part = at - vec2(low);
  const uvec2 high = min(low + 1u, size - 1u);
  const uint row = size.x >> 2;
  const uvec2 x = uvec2(low.x, high.x);
  vec3 corner[4];
  for (uint i = 0u; i < 4u; ++i) {
    const uvec2 p = uvec2(x[i & 1u], i < 2u ? low.y : high.y);
    corner[i] =
        linear_of_srgb(PAGE_NAME(block_texel)(word + 2u * ((p.y >> 2) * row + (p.x >> 2)), p.x & 3u, p.y & 3u));
  }
  const vec3 color = mix(mix(corner[0], corner[1], part.x), mix(corner[2], corner[3], part.x), part.y);
  return color * appearance_gain(appearance);
}

// Base colour, roughness and metalness of a triangle; `appearance` is 0 where the page has none or it is plain, so that
// the base colour is the material's.
SurfaceAttributes PAGE_NAME(material_attributes)(PAGE_NAME(Cluster) cluster, uint packed_triangle,
                                                 out uvec2 appearance) {
  const uint place = packed_triangle >> 24;
  uint material;
  appearance = uvec2(0u);
  if ((cluster.counts & kClusterAppearances) != 0u) {
    const uint word = cluster.palette_word + 2u * place;
    appearance = uvec2(PAGE_NAME(load)(word), PAGE_NAME(load)(word + 1u));
    material = appearance.x & 0xFFFFu;
  } else {
    material = PAGE_NAME(load)(cluster.palette_word + (place >> 1)) >> (16u * (place & 1u)) & 0xFFFFu;
  }
  const MaterialEntry m = materials[material];
  SurfaceAttributes result;
  result.base = vec3(m.base_r, m.base_g, m.base_b);
  if ((appearance.x >> 16 & 3u) == kAppearanceColor)
    result.base = linear_of_srgb(unpackUnorm4x8(appearance.y).rgb) * appearance_gain(appearance);
  result.roughness = m.roughness;
  result.metallic = m.metallic;
  result.sky = 1.0;
  result.bounce = vec3(0.0);
  result.sun = kSunUnknown;
  return result;
}

bool PAGE_NAME(is_textured)(uvec2 appearance) { return (appearance.x >> 16 & 3u) == kAppearanceTextured; }

// First words of a cluster's light and normals.
uint PAGE_NAME(light_word)(PAGE_NAME(Cluster) cluster) {
  return cluster.triangle_word - kClusterHeaderWords +
         ((kClusterHeaderWords + cluster_triangles(cluster.counts) + (3u * cluster_vertices(cluster.counts) + 1u) / 2u +
           1u) &
          ~1u);
}
uint PAGE_NAME(normal_word)(PAGE_NAME(Cluster) cluster) {
  return PAGE_NAME(light_word)(cluster) +
         ((cluster.counts & kClusterLight) != 0u ? 2u * cluster_triangles(cluster.counts) : 0u);
}

// Zero where there is none.
uvec2 PAGE_NAME(load_normals)(PAGE_NAME(Cluster) cluster, uint index) {
  if ((cluster.counts & kClusterNormals) == 0u) return uvec2(0u);
  const uint word = PAGE_NAME(normal_word)(cluster) + 2u * index;
  return uvec2(PAGE_NAME(load)(word), PAGE_NAME(load)(word + 1u));
}

// Unlit white where there is none.
uvec2 PAGE_NAME(load_light)(PAGE_NAME(Cluster) cluster, uint index) {
  if ((cluster.counts & kClusterLight) == 0u) return uvec2(0x00FFFFFFu, 0u);
  const uint word = PAGE_NAME(light_word)(cluster) + 2u * index;
  return uvec2(PAGE_NAME(load)(word), PAGE_NAME(load)(word + 1u));
}
