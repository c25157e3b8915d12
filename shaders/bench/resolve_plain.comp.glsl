// SPDX-License-Identifier: Apache-2.0
// resolve_hits.comp.glsl over the uncompressed layout: triangles are numbered through.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "passes/bindings.glsl"

layout(local_size_x = 64) in;
#include "traverse/list_index.glsl"

void main() {
  const uint i = list_index();
  if (i >= counters.ray_count) return;
  const uint hit = hits[i].triangle;
  hits[i].pixel = hit == kHitNone || hit == kHitLost ? hit : 0u;
}
