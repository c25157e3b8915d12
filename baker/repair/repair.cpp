// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/repair/repair.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <utility>

#include "baker/repair/degenerate_faces.h"
#include "baker/repair/face_edges.h"
#include "baker/repair/mesh_part.h"
#include "baker/repair/orient.h"
#include "baker/repair/slivers.h"
#include "baker/repair/stitch.h"
#include "baker/repair/t_junctions.h"
#include "base/check.h"

namespace zc {
namespace {

struct Counts {
  DegenerateFaceCounts degenerate;
  StitchCounts stitch;
  SliverCounts slivers;
  TJunctionCounts t_junctions;
  OrientCounts orient;
  std::uint64_t open_edges = 0;

  void add(const DegenerateFaceCounts& other) {
    degenerate.flat += other.flat;
    degenerate.repeated += other.repeated;
    degenerate.back_to_back += other.back_to_back;
  }
  void add(const Counts& other) {
    add(other.degenerate);
    stitch.joined += other.stitch.joined;
    stitch.moved = std::max(stitch.moved, other.stitch.moved);
    slivers.dropped += other.slivers.dropped;
    slivers.moved = std::max(slivers.moved, other.slivers.moved);
    t_junctions.repaired += other.t_junctions.repaired;
    t_junctions.left += other.t_junctions.left;
    t_junctions.moved = std::max(t_junctions.moved, other.t_junctions.moved);
    orient.turned += other.orient.turned;
    orient.one_sided_parts += other.orient.one_sided_parts;
    open_edges += other.open_edges;
  }
};

Counts repair_part(MeshPart& part) {
  Counts counts;
  counts.add(drop_degenerate_faces(part));
  counts.stitch = stitch_open_edges(part);
  if (counts.stitch.joined > 0) counts.add(drop_degenerate_faces(part));
  // What slivers leave are T-junctions.
  counts.slivers = drop_slivers(part);
  counts.t_junctions = repair_t_junctions(part);
  if (counts.t_junctions.repaired > 0) counts.add(drop_degenerate_faces(part));
  counts.orient = orient_faces(part);
  counts.open_edges = open_edges(part.mesh).size();
  return counts;
}

// Objects of each part, ascending: one a part, but all ground in one.
std::vector<std::vector<std::uint32_t>> group_objects(const std::vector<SceneObject>& objects) {
  std::vector<std::vector<std::uint32_t>> groups;
  std::vector<std::uint32_t> ground;
  for (std::uint32_t o = 0; o < objects.size(); ++o) {
    if (objects[o].kind == ObjectKind::kGround) {
      ground.push_back(o);
    } else {
      groups.push_back({o});
    }
  }
  // First: it is the largest, and nothing should wait for it.
  if (!ground.empty()) groups.insert(groups.begin(), std::move(ground));
  return groups;
}

MeshPart extract(const SnappedScene& scene, const std::vector<std::uint32_t>& objects) {
  MeshPart part;
  std::vector<std::uint32_t> used;
  for (const std::uint32_t o : objects) {
    const SceneObject& object = scene.objects[o];
    for (std::uint32_t i = object.first_triangle; i < object.first_triangle + object.triangle_count; ++i) {
      part.mesh.faces.push_back(scene.mesh.faces[i]);
      part.object.push_back(o);
      for (const std::uint32_t v : scene.mesh.faces[i].v) used.push_back(v);
    }
  }
  // The scene is welded: its vertices are sorted, and so are these.
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  part.mesh.vertices.reserve(used.size());
  for (const std::uint32_t v : used) part.mesh.vertices.push_back(scene.mesh.vertices[v]);
  for (LatticeFace& face : part.mesh.faces)
    for (std::uint32_t& v : face.v)
      v = static_cast<std::uint32_t>(std::lower_bound(used.begin(), used.end(), v) - used.begin());
  return part;
}

// Puts the faces of all parts back in the order of the scene's objects, and leaves out objects without any.
std::uint64_t gather(std::vector<MeshPart>& parts, SnappedScene& scene) {
  MeshPart all;
  for (MeshPart& part : parts) {
    append(all.mesh, part.mesh);
    all.object.insert(all.object.end(), part.object.begin(), part.object.end());
    part = {};
  }
  std::vector<std::uint32_t> next(scene.objects.size() + 1);
  for (const std::uint32_t o : all.object) ++next[o + 1];
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    scene.objects[o].first_triangle = next[o];
    scene.objects[o].triangle_count = next[o + 1];
    next[o + 1] += next[o];
  }
  scene.mesh.vertices = std::move(all.mesh.vertices);
  scene.mesh.faces.resize(all.mesh.faces.size());
  for (std::size_t i = 0; i < all.mesh.faces.size(); ++i) scene.mesh.faces[next[all.object[i]]++] = all.mesh.faces[i];
  weld(scene.mesh);
  return std::erase_if(scene.objects, [](const SceneObject& object) { return object.triangle_count == 0; });
}

// Copies of a face in several objects.
DegenerateFaceCounts drop_shared(SnappedScene& scene) {
  MeshPart all;
  all.mesh = std::move(scene.mesh);
  for (std::uint32_t o = 0; o < scene.objects.size(); ++o)
    all.object.insert(all.object.end(), scene.objects[o].triangle_count, o);
  const DegenerateFaceCounts counts = drop_degenerate_faces(all);
  std::vector<std::uint32_t> count(scene.objects.size());
  for (const std::uint32_t o : all.object) ++count[o];
  std::uint32_t first = 0;
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    scene.objects[o].first_triangle = first;
    scene.objects[o].triangle_count = count[o];
    first += count[o];
  }
  scene.mesh = std::move(all.mesh);
  weld(scene.mesh);
  return counts;
}

}  // namespace

Result<RepairedScene> repair_scene(SnappedScene&& input, BakeContext& context) {
  context.begin(BakeStage::kRepair);
  RepairedScene out = {std::move(input), {}};
  SnappedScene& scene = out.scene;
  const std::vector<std::vector<std::uint32_t>> groups = group_objects(scene.objects);
  std::vector<MeshPart> parts(groups.size());
  std::vector<Counts> part_counts(groups.size());
  tbb::parallel_for(std::size_t{0}, groups.size(), [&](std::size_t i) {
    parts[i] = extract(scene, groups[i]);
    part_counts[i] = repair_part(parts[i]);
  });
  Counts counts;
  for (const Counts& c : part_counts) counts.add(c);
  std::uint64_t emptied = gather(parts, scene);
  counts.add(drop_shared(scene));
  emptied += std::erase_if(scene.objects, [](const SceneObject& object) { return object.triangle_count == 0; });
  if (scene.mesh.faces.empty())
    return Error{ErrorCode::kFormat, "no triangle of the scene has an area at the lattice step"};

  RepairReport& report = out.report;
  const auto note = [&](const char* what, std::uint64_t count) {
    if (count > 0) report.counts.push_back({what, count});
  };
  note("triangles without area at the lattice step, dropped", counts.degenerate.flat);
  note("repeated triangles, dropped", counts.degenerate.repeated);
  note("triangles back to back with another of their object, dropped", counts.degenerate.back_to_back);
  note("triangles thinner than half a step, dropped", counts.slivers.dropped);
  note("open edges a step apart, stitched", counts.stitch.joined);
  note("T-junctions, repaired", counts.t_junctions.repaired);
  note("T-junctions left, of objects too dense with them", counts.t_junctions.left);
  note("triangles turned to their neighbours' side or outwards", counts.orient.turned);
  note("surfaces with one side only, like a Moebius strip", counts.orient.one_sided_parts);
  note("objects left without triangles", emptied);
  report.open_edges = counts.open_edges;
  report.border_error_m =
      std::max({counts.stitch.moved, counts.slivers.moved, counts.t_junctions.moved}) * scene.lattice.step_m();
  return out;
}

}  // namespace zc
