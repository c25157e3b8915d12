// SPDX-License-Identifier: Apache-2.0
// Gives hits as pages know them, for who reads them back: a ResolvedHit in the place of each HitRecord.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "passes/bindings.glsl"
#include "page/zone_set.glsl"
#include "page/page_fetch.glsl"
#include "page/end_set.glsl"

layout(local_size_x = 64) in;
#include "traverse/list_index.glsl"

layout(set = 0, binding = kBindHits, std430) writeonly buffer ResolvedHits { ResolvedHit resolved_hits[]; };

void main() {
  const uint i = list_index();
  if (i >= counters.ray_count) return;
  const HitRecord hit = hits[i];
  ResolvedHit resolved = ResolvedHit(hit.t, hit.triangle_word, 0u);
  if (hit.triangle_word != kHitNone && hit.triangle_word != kHitLost) {
    resolved.page_word = page_zone_at(hit.triangle_word).page_word;
    const page_Cluster cluster = page_cluster_at(resolved.page_word, hit.triangle_word);
    resolved.triangle = cluster.first_triangle + hit.triangle_word - cluster.triangle_word;
  }
  resolved_hits[i] = resolved;
}
