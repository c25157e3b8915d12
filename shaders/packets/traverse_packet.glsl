// SPDX-License-Identifier: Apache-2.0
// Closest or any hits of a packet of rays by a lane group of eight invocations, against one set of zones in some layout
// (page_layout.glsl, page_layout_group.glsl). Every invocation owns kRaysPerLane rays (packet_rays.glsl), but nodes and
// triangles are culled the other way round: invocation = child box, then invocation = triangle, each against a frustum
// that contains all rays of a group (frustum.glsl). Only the triangles that are left are tested invocation = ray. A
// node thus costs about the same for eight rays and for sixty-four, and is fetched and decoded once.
//
// What does not pay becomes a fallback ray of the traversal of single rays: groups that are too small, and groups whose
// frustum intersected more than kStepsPerRay nodes and batches of triangles a ray. Both traversals find the same
// triangle, so it does not matter which did.
//
// With kAnyHit a ray that has a hit leaves the group, and the frustum shrinks to those that are left.

struct PAGE_NAME(GroupNode) {
  uint triangles;  // bit i: triangle i of the node is to be tested
  uint triangle_word;
  uint cluster_word;
};

// On to the next node with triangles that the frustum may hit. False: there is none, or the budget is used up.
// Loops test at their ends: llvmpipe runs through a branch, and once through a loop, with every lane masked off.
bool PAGE_NAME(find_triangles)(RayGroup group, Frustum frustum, uint budget, inout uint steps, inout uvec2 entry,
                               inout bool finished, out PAGE_NAME(GroupNode) found) {
  const uint slot = group_lane ^ group.octant;  // of this lane's children: by lanes they are roughly front to back
  found.triangles = 0u;
  do {
    if ((entry.y >> 24) == 0u) {
      finished = packet_stack_size == 0u;
      if (finished) break;
      entry = pop_entry();
    }
    ++steps;
    const uint node = take_child(entry, group.octant, PAGE_NAME(node_words));
    if ((entry.y >> 24) != 0u) push_entry(entry);
    vec3 box_low;
    vec3 box_high;
    const NodeRefs refs = PAGE_NAME(load_child)(node, slot, group.longest, box_low, box_high);
    const bool hit = frustum_hits_box(frustum, box_low, box_high);
    found.triangles = group_or(hit ? slot_triangles(refs.counts, slot) : 0u);
    found.triangle_word = refs.triangle_word;
    found.cluster_word = refs.cluster_word;
    entry = uvec2(refs.child_word, group_ballot(hit && (refs.inner >> slot & 1u) != 0u) << 24 | refs.inner);
  } while (found.triangles == 0u && steps < budget);
  return found.triangles != 0u;
}

// Eight triangles at a time, from the first that is left; lane i has the i-th.
void PAGE_NAME(test_triangles)(RayGroup group, Frustum frustum, PAGE_NAME(GroupNode) node, inout uint steps) {
  const PAGE_NAME(Cluster) cluster = PAGE_NAME(load_group_cluster)(node.cluster_word);
  const float own_height_m = cluster.error_m + 2.0 * frame.step_m;
  do {
    uint first;  // of the eight triangles at hand
    uint hit;    // bit per lane: its triangle is still to be tested
    uint own;
    Triangle shape;
    do {
      ++steps;
      first = uint(findLSB(node.triangles));
      const bool candidate =
          first + group_lane < kNodeMaxTriangles && (node.triangles >> (first + group_lane) & 1u) != 0u;
      node.triangles &= first < 24u ? 0xFFFFFFFFu << (first + kLaneGroup) : 0u;
      vec3 a;
      vec3 b;
      vec3 c;
      PAGE_NAME(load_triangle)(cluster, node.triangle_word + (candidate ? first + group_lane : first), a, b, c);
      shape = make_triangle(permute(a, group.longest), permute(b, group.longest), permute(c, group.longest));
      hit = group_ballot(candidate && frustum_hits_triangle(frustum, shape));
      own = group.has_origin_surface && winds_with(shape.normal, group.plane) ? 1u : 0u;
    } while (hit == 0u && node.triangles != 0u);
    do {
      const uint lane = uint(findLSB(hit));
      const Triangle one =
          Triangle(from_lane(shape.a, lane), from_lane(shape.b, lane), from_lane(shape.c, lane),
                   from_lane(shape.normal, lane), from_lane(shape.z_low, lane), from_lane(shape.z_high, lane));
      test_rays(one, node.triangle_word + first + lane, from_lane(own, lane) != 0u, own_height_m);
      hit &= hit - 1u;
    } while (hit != 0u);
  } while (node.triangles != 0u);
}

void PAGE_NAME(trace_group)(RayGroup group, Frustum frustum) {
  const uint budget = kStepsPerRay * group.size;
  uint steps = group.size < kGroupLeast ? budget : 0u;
  bool finished = false;
  uvec2 entry = root_group(SET_ROOT);
  clear_packet_stack();
  while (steps < budget && !finished) {
    PAGE_NAME(GroupNode) node;
    if (!PAGE_NAME(find_triangles)(group, frustum, budget, steps, entry, finished, node)) break;
    PAGE_NAME(test_triangles)(group, frustum, node, steps);
    finished = !shrink_frustum(group, frustum);
  }
  end_group(group, finished);
}

void PAGE_NAME(trace_packet)(uint first_ray) {
  take_rays(first_ray);
  for (uint round = 0u; round < kLaneGroup * uint(kRaysPerLane); ++round) {
    RayGroup group;
    Frustum frustum;
    if (!next_group(first_ray, group, frustum)) break;
    PAGE_NAME(trace_group)(group, frustum);
  }
  put_rays(first_ray);
}
