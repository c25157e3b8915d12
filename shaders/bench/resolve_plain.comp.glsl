// SPDX-License-Identifier: Apache-2.0
// resolve_hits.comp.glsl over the uncompressed layout: triangles are numbered through.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "passes/bindings.glsl"

layout(local_size_x = 64) in;
#include "traverse/list_index.glsl"

layout(set = 0, binding = kBindHits, std430) writeonly buffer ResolvedHits { ResolvedHit resolved_hits[]; };

void main() {
  const uint i = list_index();
  if (i >= counters.ray_count) return;
  const HitRecord hit = hits[i];
  const bool none = hit.triangle_word == kHitNone || hit.triangle_word == kHitLost;
  resolved_hits[i] = ResolvedHit(hit.t, none ? hit.triangle_word : 0u, hit.triangle_word);
}
