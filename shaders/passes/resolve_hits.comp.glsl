// SPDX-License-Identifier: Apache-2.0
// Says hits as pages know them, for who reads them back: in `pixel` the page's first word, in `triangle` the position
// in that page.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "passes/bindings.glsl"
#include "traverse/trace.glsl"
#include "page/zone_set.glsl"
#include "page/page_fetch.glsl"
#include "page/end_set.glsl"

layout(local_size_x = 64) in;
#include "traverse/list_index.glsl"

void main() {
  const uint i = list_index();
  if (i >= counters.ray_count) return;
  const uint hit = hits[i].triangle;
  if (hit == kHitNone || hit == kHitLost) {
    hits[i].pixel = hit;
  } else {
    const zone_Cluster cluster = zone_load_cluster(hit_cluster_word(hit));
    hits[i].triangle = cluster.first_triangle + hit_index(hit);
    hits[i].pixel = cluster.page_word;
  }
}
