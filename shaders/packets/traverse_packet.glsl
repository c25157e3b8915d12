// SPDX-License-Identifier: Apache-2.0
// Closest or any hits of a packet of rays by a lane group of eight invocations, against one set of zones in some layout
// (page_layout.glsl, page_layout_group.glsl). Every invocation owns kRaysPerLane rays, but nodes and triangles are
// culled the other way round: invocation = child box, then invocation = triangle, each against a frustum that holds the
// whole packet. Only the triangles that are left are tested invocation = ray. A node thus costs about the same for
// eight rays and for sixty-four, and is fetched and decoded once.
// The frustum is frustum.glsl's.
//
// Rays form groups that leave the same plane, run along the same axis and differ little in direction. What does not pay
// becomes a fallback ray of the traversal of single rays: groups that are too small, and groups whose frustum met more
// than kStepsPerRay nodes and batches of triangles a ray. Both traversals find the same triangle, so it does not matter
// which did.
//
// With kAnyHit a ray that has a hit leaves the packet, and the frustum shrinks to those that are left.
void PAGE_NAME(trace_packet)(uint first_ray) {
  const float step_m = frame.step_m;
  const float per_m = 1.0 / step_m;
  vec3 origin[kRaysPerLane];  // permuted by the ray's longest axis, like the scale of its shear
  vec3 scale[kRaysPerLane];
  float t_min[kRaysPerLane];
  float cos_theta[kRaysPerLane];
  float
      t_max[kRaysPerLane];  // of the nearest hit, once there is one; negative while the ray is not in the group at hand
  uint best[kRaysPerLane];
  uint origin_normals[kRaysPerLane];
  uint axes = 0u;   // four bits a ray: the axis and which way along it
  uint left = 0u;   // bit per ray of this lane: still to be traced
  uint again = 0u;  // bit per ray: to be given back

  for (int r = 0; r < kRaysPerLane; ++r) {
    const uint index = first_ray + kLaneGroup * uint(r) + group_lane;
    const bool there = index < counters.ray_count;
    const RayTask task = load_ray(there ? index : first_ray);
    const Shear shear = make_shear(vec3(task.dir_x, task.dir_y, task.dir_z));
    origin[r] = permute(vec3(task.origin_x, task.origin_y, task.origin_z) * per_m, shear.longest);
    scale[r] = shear.scale;
    t_min[r] = task.t_min * per_m;
    t_max[r] = -frame.ray_length_m * per_m;
    cos_theta[r] = 0.0;
    best[r] = kHitNone;
    origin_normals[r] = task.origin_normal;
    axes |= axis_code(shear) << (4 * r);
    left |= there ? 1u << r : 0u;
  }

  for (uint round = 0u; round < kLaneGroup * uint(kRaysPerLane); ++round) {
    // The leader: the first ray that is left.
    const uint lead_ray = group_min(left != 0u ? uint(findLSB(left)) * kLaneGroup + group_lane : 0xFFFFFFFFu);
    if (lead_ray == 0xFFFFFFFFu) break;
    const RayTask lead = load_ray(first_ray + lead_ray);
    const vec3 lead_direction = vec3(lead.dir_x, lead.dir_y, lead.dir_z);
    const bool has_origin_surface = lead.origin_normal != kNoSurface;
    const Shear lead_shear = make_shear(lead_direction);
    const int longest = lead_shear.longest;
    const uint lead_code = axis_code(lead_shear);
    const vec3 lead_axis = permute(lead_direction, longest);
    const float forward = lead_axis.z < 0.0 ? -1.0 : 1.0;
    const uint octant = direction_octant(lead_direction);
    const uint slot = group_lane ^ octant;  // of this lane's children: by lanes they are roughly front to back
    const vec3 lead_plane = permute(unpack_normal(lead.origin_normal), longest);

    // Who comes along; the packet's frustum. Along the axis it begins at the first origin: z counts from there,
    // forward.
    uint members = 0u;  // bit per ray of this lane
    float start = kNever;
    for (int r = 0; r < kRaysPerLane; ++r) {
      const bool joins = (left >> r & 1u) != 0u && origin_normals[r] == lead.origin_normal &&
                         (axes >> (4 * r) & 7u) == lead_code &&
                         dot(vec3(scale[r].xy, 1.0), lead_axis) / scale[r].z > kGroupCosine;
      members |= joins ? 1u << r : 0u;
      cos_theta[r] = joins ? cos_theta_of(scale[r], lead_plane) : cos_theta[r];
      t_max[r] = joins ? -t_max[r] : t_max[r];
      start = min(start, joins ? (origin[r].z + t_min[r] / scale[r].z) * forward : kNever);
    }
    left &= ~members;
    start = group_min(start);
    start -= abs(start) * 1e-6;
    Frustum frustum = empty_frustum(start, forward);
    uint size = 0u;
    for (int r = 0; r < kRaysPerLane; ++r) {
      const bool member = (members >> r & 1u) != 0u;
      size += member ? 1u : 0u;
      widen_frustum(frustum, member, origin[r], scale[r], t_max[r]);
    }
    gather_frustum(frustum);
    const uint group_size = group_sum(size);

    const uint budget = kStepsPerRay * group_size;
    uint steps = group_size < kGroupLeast ? budget : 0u;
    // The stack lies across the lanes: entry i is lane i % 8's, in its pair i / 8 of registers.
    uvec2 stack[kStackPairs];
    for (uint pair = 0u; pair < kStackPairs; ++pair) stack[pair] = uvec2(0u);
    uint sp = 0u;
    uvec2 group = root_group(SET_ROOT);
    bool finished = false;
    uint triangles = 0u;  // bit i: triangle i of the node that was visited last is to be tested
    uint triangle_word = 0u;
    uint cluster_word = 0u;
    // Loops test at their ends: llvmpipe runs through a branch, and once through a loop, with every lane masked off.
    while (steps < budget && !finished) {
      do {
        if ((group.y >> 24) == 0u) {
          finished = sp == 0u;
          if (finished) break;
          --sp;
          uvec2 entries = stack[0];
          for (uint pair = 1u; pair < kStackPairs; ++pair) entries = sp >= pair * kLaneGroup ? stack[pair] : entries;
          group = uvec2(from_lane(entries.x, sp & 7u), from_lane(entries.y, sp & 7u));
        }
        ++steps;
        const uint node = take_child(group, octant, PAGE_NAME(node_words));
        if ((group.y >> 24) != 0u) {
          for (uint pair = 0u; pair < kStackPairs; ++pair)
            stack[pair] = sp == pair * kLaneGroup + group_lane ? group : stack[pair];
          ++sp;
        }
        vec3 box_low;
        vec3 box_high;
        const NodeRefs refs = PAGE_NAME(load_child)(node, slot, longest, box_low, box_high);
        const bool met = frustum_hits_box(frustum, box_low, box_high);
        triangles = group_or(met ? slot_triangles(refs.counts, slot) : 0u);
        triangle_word = refs.triangle_word;
        cluster_word = refs.cluster_word;
        group = uvec2(refs.child_word, group_ballot(met && (refs.inner >> slot & 1u) != 0u) << 24 | refs.inner);
      } while (triangles == 0u && steps < budget);
      if (triangles == 0u) break;

      const PAGE_NAME(Cluster) cluster = PAGE_NAME(load_group_cluster)(cluster_word);
      const float own_height_m = cluster.error_m + 2.0 * step_m;
      do {
        uint first;  // of the eight triangles at hand
        uint met;    // bit per lane: its triangle is still to be tested
        uint own;
        Triangle shape;
        do {
          // Eight triangles at a time, from the first that is left; lane i has the i-th.
          ++steps;
          first = uint(findLSB(triangles));
          const bool candidate =
              first + group_lane < kNodeMaxTriangles && (triangles >> (first + group_lane) & 1u) != 0u;
          triangles &= first < 24u ? 0xFFFFFFFFu << (first + kLaneGroup) : 0u;
          vec3 a;
          vec3 b;
          vec3 c;
          PAGE_NAME(load_triangle)(cluster, triangle_word + (candidate ? first + group_lane : first), a, b, c);
          shape = make_triangle(permute(a, longest), permute(b, longest), permute(c, longest));
          met = group_ballot(candidate && frustum_hits_triangle(frustum, shape));
          own = has_origin_surface && winds_with(shape.normal, lead_plane) ? 1u : 0u;
        } while (met == 0u && triangles != 0u);
        do {
          const uint lane = uint(findLSB(met));
          const uint hit = triangle_word + first + lane;
          const Triangle one =
              Triangle(from_lane(shape.a, lane), from_lane(shape.b, lane), from_lane(shape.c, lane),
                       from_lane(shape.normal, lane), from_lane(shape.z_low, lane), from_lane(shape.z_high, lane));
          const bool is_own = from_lane(own, lane) != 0u;
          for (int r = 0; r < kRaysPerLane; ++r) {
            float t;
            const bool inside = hit_triangle(one, origin[r], scale[r], t);
            const bool take = inside && t >= t_min[r] && (t < t_max[r] || (t == t_max[r] && hit < best[r])) &&
                              !(is_own && t * cos_theta[r] * step_m <= own_height_m);
            t_max[r] = take ? (kAnyHit != 0u ? -t : t) : t_max[r];
            best[r] = take ? hit : best[r];
          }
          met &= met - 1u;
        } while (met != 0u);
      } while (triangles != 0u);
      if (kAnyHit != 0u) {
        frustum = empty_frustum(start, forward);
        for (int r = 0; r < kRaysPerLane; ++r) widen_frustum(frustum, t_max[r] >= 0.0, origin[r], scale[r], t_max[r]);
        gather_frustum(frustum);
        finished = frustum.z_last < 0.0;
      } else {
        float last = -kNever;
        for (int r = 0; r < kRaysPerLane; ++r)
          last = max(last, t_max[r] >= 0.0 ? reach_of(frustum, origin[r], scale[r], t_max[r]) : -kNever);
        frustum.z_last = group_max(last) * 1.000002;
      }
    }

    if (kAnyHit != 0u) {
      for (int r = 0; r < kRaysPerLane; ++r) members &= best[r] == kHitNone ? 0xFFFFFFFFu : ~(1u << r);
    }
    again |= finished ? 0u : members;
    for (int r = 0; r < kRaysPerLane; ++r) t_max[r] = -abs(t_max[r]);
  }

  for (int r = 0; r < kRaysPerLane; ++r) {
    const uint index = first_ray + kLaneGroup * uint(r) + group_lane;
    if (index < counters.ray_count) {
      hits[index].t = -t_max[r] * step_m;
      hits[index].triangle_word = best[r];
    }
  }
  const uint byte_of_lane = again << (8u * (group_lane & 3u));
  const uint mask_low = group_or(group_lane < 4u ? byte_of_lane : 0u);
  const uint mask_high = group_or(group_lane < 4u ? 0u : byte_of_lane);
  if (group_lane == 0u && (mask_low | mask_high) != 0u)
    fallback_rays[atomicAdd(counters.fallback_count, 1u)] = FallbackRays(first_ray, mask_low, mask_high);
}
