// SPDX-License-Identifier: Apache-2.0
// The rays of a packet, kRaysPerLane to an invocation, and the groups of them that are traced together: rays that leave
// the same plane, run along the same axis and differ little in direction. Nothing here depends on what is traced.
// Needs lane_group.glsl, frustum.glsl, trace.glsl and the ray queue.

// This invocation's rays. (Of the file, not of a function: a function's arguments are copied in and out.)
vec3 ray_origin[kRaysPerLane];  // permuted by the ray's longest axis, like the scale of its shear
vec3 ray_scale[kRaysPerLane];
float ray_t_min[kRaysPerLane];
float ray_t_max[kRaysPerLane];  // of the nearest hit, once there is one; negative while the ray is not in the group
float ray_cos_theta[kRaysPerLane];
uint ray_best[kRaysPerLane];
uint ray_normal[kRaysPerLane];
uint ray_axes;    // four bits a ray: the axis and which way along it
uint rays_left;   // bit per ray: still to be traced
uint rays_again;  // bit per ray: to become a fallback ray

void take_rays(uint first_ray) {
  const float per_m = 1.0 / frame.step_m;
  ray_axes = 0u;
  rays_left = 0u;
  rays_again = 0u;
  for (int r = 0; r < kRaysPerLane; ++r) {
    const uint index = first_ray + kLaneGroup * uint(r) + group_lane;
    const bool there = index < counters.ray_count;
    const RayTask task = load_ray(there ? index : first_ray);
    const Shear shear = make_shear(vec3(task.dir_x, task.dir_y, task.dir_z));
    ray_origin[r] = permute(vec3(task.origin_x, task.origin_y, task.origin_z) * per_m, shear.longest);
    ray_scale[r] = shear.scale;
    ray_t_min[r] = task.t_min * per_m;
    ray_t_max[r] = -frame.ray_length_m * per_m;
    ray_cos_theta[r] = 0.0;
    ray_best[r] = kHitNone;
    ray_normal[r] = task.origin_normal;
    ray_axes |= axis_code(shear) << (4 * r);
    rays_left |= there ? 1u << r : 0u;
  }
}

struct RayGroup {
  uint members;  // bit per ray of this invocation
  uint size;     // rays of all invocations
  int longest;   // axis
  float forward;
  float start;   // of the frustum
  uint octant;
  bool has_origin_surface;
  vec3 plane;    // that the rays leave, permuted
};

// The first ray that is left, and who goes along with it. False: none is left.
bool next_group(uint first_ray, out RayGroup group, out Frustum frustum) {
  const uint lead_ray = group_min(rays_left != 0u ? uint(findLSB(rays_left)) * kLaneGroup + group_lane : 0xFFFFFFFFu);
  if (lead_ray == 0xFFFFFFFFu) return false;
  const RayTask lead = load_ray(first_ray + lead_ray);
  const vec3 direction = vec3(lead.dir_x, lead.dir_y, lead.dir_z);
  const Shear shear = make_shear(direction);
  const uint code = axis_code(shear);
  const vec3 axis = permute(direction, shear.longest);
  group.longest = shear.longest;
  group.forward = axis.z < 0.0 ? -1.0 : 1.0;
  group.octant = direction_octant(direction);
  group.has_origin_surface = lead.origin_normal != kNoSurface;
  group.plane = permute(unpack_normal(lead.origin_normal), shear.longest);

  // Along the axis the frustum begins at the first origin: z counts from there, forward.
  group.members = 0u;
  float start = kNever;
  for (int r = 0; r < kRaysPerLane; ++r) {
    const bool joins = (rays_left >> r & 1u) != 0u && ray_normal[r] == lead.origin_normal &&
                       (ray_axes >> (4 * r) & 7u) == code &&
                       dot(vec3(ray_scale[r].xy, 1.0), axis) / ray_scale[r].z > kGroupCosine;
    group.members |= joins ? 1u << r : 0u;
    ray_cos_theta[r] = joins ? cos_theta_of(ray_scale[r], group.plane) : ray_cos_theta[r];
    ray_t_max[r] = joins ? -ray_t_max[r] : ray_t_max[r];
    start = min(start, joins ? (ray_origin[r].z + ray_t_min[r] / ray_scale[r].z) * group.forward : kNever);
  }
  rays_left &= ~group.members;
  start = group_min(start);
  group.start = start - abs(start) * 1e-6;
  frustum = empty_frustum(group.start, group.forward);
  uint size = 0u;
  for (int r = 0; r < kRaysPerLane; ++r) {
    const bool member = (group.members >> r & 1u) != 0u;
    size += member ? 1u : 0u;
    widen_frustum(frustum, member, ray_origin[r], ray_scale[r], ray_t_max[r]);
  }
  gather_frustum(frustum);
  group.size = group_sum(size);
  return true;
}

// After hits: the frustum ends where the farthest ray does; with kAnyHit it is that of the rays without one. False:
// none is left.
bool shrink_frustum(RayGroup group, inout Frustum frustum) {
  if (kAnyHit != 0u) {
    frustum = empty_frustum(group.start, group.forward);
    for (int r = 0; r < kRaysPerLane; ++r)
      widen_frustum(frustum, ray_t_max[r] >= 0.0, ray_origin[r], ray_scale[r], ray_t_max[r]);
    gather_frustum(frustum);
    return frustum.z_last >= 0.0;
  }
  float last = -kNever;
  for (int r = 0; r < kRaysPerLane; ++r)
    last = max(last, ray_t_max[r] >= 0.0 ? reach_of(frustum, ray_origin[r], ray_scale[r], ray_t_max[r]) : -kNever);
  frustum.z_last = group_max(last) * 1.000002;
  return true;
}

// Holds a triangle, which is the same for every invocation, against the invocation's rays. own_height_m: up to which
// height over the plane that the rays leave a hit is that surface itself; negative where it cannot be.
void test_rays(Triangle triangle, uint triangle_word, bool is_own, float own_height_m) {
  const float step_m = frame.step_m;
  for (int r = 0; r < kRaysPerLane; ++r) {
    float t;
    const bool inside = hit_triangle(triangle, ray_origin[r], ray_scale[r], t);
    const bool take = inside && t >= ray_t_min[r] &&
                      (t < ray_t_max[r] || (t == ray_t_max[r] && triangle_word < ray_best[r])) &&
                      !(is_own && t * ray_cos_theta[r] * step_m <= own_height_m);
    ray_t_max[r] = take ? (kAnyHit != 0u ? -t : t) : ray_t_max[r];
    ray_best[r] = take ? triangle_word : ray_best[r];
  }
}

// finished: the group has seen all that it can hit; else its rays become fallback rays, but those that have any hit
// where that is enough.
void end_group(RayGroup group, bool finished) {
  uint members = group.members;
  if (kAnyHit != 0u) {
    for (int r = 0; r < kRaysPerLane; ++r) members &= ray_best[r] == kHitNone ? 0xFFFFFFFFu : ~(1u << r);
  }
  rays_again |= finished ? 0u : members;
  for (int r = 0; r < kRaysPerLane; ++r) ray_t_max[r] = -abs(ray_t_max[r]);
}

void put_rays(uint first_ray) {
  for (int r = 0; r < kRaysPerLane; ++r) {
    const uint index = first_ray + kLaneGroup * uint(r) + group_lane;
    if (index < counters.ray_count) {
      hits[index].t = -ray_t_max[r] * frame.step_m;
      hits[index].triangle_word = ray_best[r];
    }
  }
  const uint byte_of_lane = rays_again << (8u * (group_lane & 3u));
  const uint mask_low = group_or(group_lane < 4u ? byte_of_lane : 0u);
  const uint mask_high = group_or(group_lane < 4u ? 0u : byte_of_lane);
  if (group_lane == 0u && (mask_low | mask_high) != 0u)
    fallback_rays[atomicAdd(counters.fallback_count, 1u)] = FallbackRays(first_ray, mask_low, mask_high);
}

const uint kStackPairs = (uint(kStackSize) + kLaneGroup - 1u) / kLaneGroup;  // of registers a lane

// The group's stack lies across the lanes: entry i is lane i % 8's, in its pair i / 8 of registers.
uvec2 packet_stack[kStackPairs];
uint packet_stack_size;

void clear_packet_stack() {
  for (uint pair = 0u; pair < kStackPairs; ++pair) packet_stack[pair] = uvec2(0u);
  packet_stack_size = 0u;
}
void push_entry(uvec2 entry) {
  for (uint pair = 0u; pair < kStackPairs; ++pair)
    packet_stack[pair] = packet_stack_size == pair * kLaneGroup + group_lane ? entry : packet_stack[pair];
  ++packet_stack_size;
}
// There must be one.
uvec2 pop_entry() {
  --packet_stack_size;
  uvec2 entries = packet_stack[0];
  for (uint pair = 1u; pair < kStackPairs; ++pair)
    entries = packet_stack_size >= pair * kLaneGroup ? packet_stack[pair] : entries;
  return uvec2(from_lane(entries.x, packet_stack_size & 7u), from_lane(entries.y, packet_stack_size & 7u));
}
