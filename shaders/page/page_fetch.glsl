// SPDX-License-Identifier: Apache-2.0
// Reading pages of one set of zones. Needs PAGE_NAME, the pool by words (POOL, TEXELS) and by four (POOL4, TEXELS4).
// Vertices come out as exact floats in lattice units relative to the camera's lattice point: |q + offset| stays below
// 2^24 steps near the camera.

// The zone in whose page a word of the pool lies; the zone table is sorted by page.
ZoneEntry PAGE_NAME(zone_at)(uint word) {
  uint low = 0u;
  for (uint count = SET_ZONES; count > 1u;) {
    const uint half_count = count >> 1;
    low = ZONES[low + half_count].page_word <= word ? low + half_count : low;
    count -= half_count;
  }
  return ZONES[low];
}

// With kCheckAccess: `word`, where `count` words from it on lie in the top level or in one of the pages that it leads
// to; elsewhere the access is counted and goes to word 0 instead.
uint PAGE_NAME(checked)(uint word, uint count) {
#ifdef ACCESS_COUNTER
  if (kCheckAccess == 0u) return word;
  bool inside = word % count == 0u;
  if (word >= SET_ROOT) {
    inside = inside && word < SET_END && count <= SET_END - word;
  } else {
    const uint page_word = SET_ZONES > 0u ? PAGE_NAME(zone_at)(word).page_word : SET_ROOT;
    const uint from = word - page_word;
    const uint size = page_word < SET_ROOT ? POOL[page_word + kPageTotalWord] : 0u;
    inside = inside && word >= page_word && from < size && count <= size - from;
  }
  if (!inside) atomicAdd(ACCESS_COUNTER, 1u);
  return inside ? word : 0u;
#else
  return word;
#endif
}

uint PAGE_NAME(load)(uint at) {
  const uint word = PAGE_NAME(checked)(at, 1u);
  return kPoolPath == kPoolTexels ? texelFetch(TEXELS, int(word)).x : POOL[word];
}

// `at` is a multiple of four.
uvec4 PAGE_NAME(load4)(uint at) {
  const uint word = PAGE_NAME(checked)(at, 4u);
  return kPoolPath == kPoolTexels ? texelFetch(TEXELS4, int(word >> 2)) : POOL4[word >> 2];
}

struct PAGE_NAME(Cluster) {
  ivec3 offset;  // from the camera's lattice point
  int shift;
  uint counts;  // with its flags
  uint triangle_word;  // first word of the triangles, the vertices and the palette in the pool
  uint vertex_word;
  uint palette_word;
  uint page_word;
  uint first_triangle;
  float error_m;
};

// Of the header's two times four words.
PAGE_NAME(Cluster) PAGE_NAME(cluster_of)(uint word, uvec4 a, uvec4 b) {
  PAGE_NAME(Cluster) c;
  c.offset = ivec3(a.xyz) - frame.camera_lattice.xyz;
  c.shift = int(a.w >> kClusterShiftBit);
  c.counts = a.w;
  c.triangle_word = word + kClusterHeaderWords;
  c.vertex_word = c.triangle_word + cluster_triangles(a.w);
  c.error_m = uintBitsToFloat(b.x);
  c.page_word = word - b.y;
  c.first_triangle = b.z;
  c.palette_word = word + b.w;
  return c;
}

PAGE_NAME(Cluster) PAGE_NAME(load_cluster)(uint word) {
  return PAGE_NAME(cluster_of)(word, PAGE_NAME(load4)(word), PAGE_NAME(load4)(word + 4u));
}

vec3 PAGE_NAME(load_vertex)(uint vertex_word, ivec3 offset, int shift, uint v) {
  const uint word = vertex_word + ((3u * v) >> 1);
  const uint w0 = PAGE_NAME(load)(word);
  const uint w1 = PAGE_NAME(load)(word + 1u);
  const bool odd = (v & 1u) != 0u;
  const uvec3 q = odd ? uvec3(w0 >> 16, w1 & 0xFFFFu, w1 >> 16) : uvec3(w0 & 0xFFFFu, w0 >> 16, w1 & 0xFFFFu);
  return vec3((ivec3(q) << shift) + offset);
}

// The corners of a triangle word.
void PAGE_NAME(load_corners)(PAGE_NAME(Cluster) cluster, uint packed_triangle, out vec3 a, out vec3 b, out vec3 c) {
  a = PAGE_NAME(load_vertex)(cluster.vertex_word, cluster.offset, cluster.shift, packed_triangle & 0xFFu);
  b = PAGE_NAME(load_vertex)(cluster.vertex_word, cluster.offset, cluster.shift, (packed_triangle >> 8) & 0xFFu);
  c = PAGE_NAME(load_vertex)(cluster.vertex_word, cluster.offset, cluster.shift, (packed_triangle >> 16) & 0xFFu);
}

// The cluster of the last entry in a page's cluster table whose `member`-th word is not larger than `value`.
PAGE_NAME(Cluster) PAGE_NAME(search_clusters)(uint page_word, uint member, uint value) {
  uint low = page_word + PAGE_NAME(load)(page_word + 5u);  // the first entry
  uint count = PAGE_NAME(load)(page_word + 4u);
  while (count > 1u) {
    const uint half_count = count >> 1;
    const uint middle = low + half_count * kClusterEntryWords;
    low = PAGE_NAME(load)(middle + member) <= value ? middle : low;
    count -= half_count;
  }
  return PAGE_NAME(load_cluster)(page_word + PAGE_NAME(load)(low + 1u));
}

// The cluster of a triangle, by its position in the page and by its word in the pool.
PAGE_NAME(Cluster) PAGE_NAME(find_cluster)(uint page_word, uint triangle) {
  return PAGE_NAME(search_clusters)(page_word, 0u, triangle);
}
PAGE_NAME(Cluster) PAGE_NAME(cluster_at)(uint page_word, uint triangle_word) {
  return PAGE_NAME(search_clusters)(page_word, 1u, triangle_word - page_word);
}
