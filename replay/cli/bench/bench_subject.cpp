// SPDX-License-Identifier: Apache-2.0
#include "replay/cli/bench/bench_subject.h"

#include <spdlog/spdlog.h>

#include <cmath>
#include <glm/common.hpp>
#include <limits>

#include "baker/cut/cut.h"
#include "baker/generate/city.h"
#include "baker/import/import.h"
#include "baker/repair/repair.h"
#include "baker/repair/snap.h"
#include "replay/files/temporary_folder.h"

namespace zc::bench {
namespace {

// Raw triangles within this of zero are exact in floats as they are; others are traced around a whole metre in their
// middle.
constexpr double kPlainFrameM = 32768;

// Snaps, repairs and cuts as a bake does, without proxies.
Result<BenchScene> cut_scene(std::string name, Scene&& soup, std::uint32_t leaf_triangles,
                             const std::optional<CrsPoint>& origin) {
  BakeContext context;
  ZC_ASSIGN(const WorldLattice lattice, fit_lattice(soup, kDefaultStepLog2));
  ZC_ASSIGN(SnappedScene snapped, snap_scene({std::move(soup), lattice}, context));
  ZC_ASSIGN(RepairedScene repaired, repair_scene(std::move(snapped), context));
  const CellGrid grid = fit_cells(repaired.scene, leaf_triangles);
  ZC_ASSIGN(CutScene cut,
            cut_zones({.scene = std::move(repaired.scene), .leaf_triangles = leaf_triangles, .grid = grid}, context));
  for (const ImportCount& note : repaired.report.counts) spdlog::info("{}: {}", note.what, note.count);
  for (const ImportCount& note : cut.notes) spdlog::info("{}: {}", note.what, note.count);
  SceneAssembly assembly(std::move(name), origin.value_or(lattice.anchor), lattice.step_m());
  for (Zone& zone : cut.tree.zones) {
    if (zone.detail.faces.empty()) continue;
    const std::uint32_t shift = step_shift_for_box(bounds_of(zone.detail));
    round_to_step(zone.detail, shift);
    assembly.begin_zone(shift);
    for (const LatticeFace& face : zone.detail.faces) {
      std::array<CrsPoint, 3> corners;
      for (std::size_t i = 0; i < 9; ++i)
        corners[i / 3][i % 3] = lattice.anchor[i % 3] + zone.detail.vertices[face.v[i / 3]][i % 3];
      ZC_TRY(assembly.add(corners));
    }
  }
  return std::move(assembly).finish();
}

struct RawTriangles {
  Scene soup;
  glm::dvec3 frame_m = {};  // the point of the file's coordinates that becomes the local origin
};

Result<RawTriangles> read_triangles(const std::string& file, const glm::dvec3& offset_m) {
  ZC_ASSIGN(const RawRecords records, read_raw_records(file, 9));
  if (records.values.empty())
    return Error{ErrorCode::kFormat,
                 std::string("contains no triangle") + (records.dropped == 0 ? "" : " of numbers within 1.8e18"), file};
  if (records.dropped > 0)
    spdlog::warn("{}: {} triangles with values that are no numbers or beyond 1.8e18, dropped", file, records.dropped);
  RawTriangles raw;
  constexpr double kBeyondAll = std::numeric_limits<double>::infinity();
  glm::dvec3 low(kBeyondAll), high(-kBeyondAll);
  Scene& soup = raw.soup;
  for (std::size_t at = 0; at < records.values.size(); at += 3) {
    const glm::dvec3 p(records.values[at], records.values[at + 1], records.values[at + 2]);
    low = glm::min(low, p);
    high = glm::max(high, p);
    soup.positions.push_back(p + offset_m);
  }
  const auto count = static_cast<std::uint32_t>(soup.positions.size() / 3);
  for (std::uint32_t i = 0; i < count; ++i) soup.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  soup.triangle_material.resize(count);
  soup.materials.emplace_back();
  soup.objects.push_back({"triangles", ObjectKind::kGround, 0, count});
  for (int axis = 0; axis < 3; ++axis) {
    if (std::max(std::abs(low[axis]), std::abs(high[axis])) > kPlainFrameM)
      raw.frame_m[axis] = std::round((low[axis] + high[axis]) / 2);
  }
  return raw;
}

Result<CameraSample> read_camera(const std::string& path, std::uint64_t frame, const glm::dvec3& offset_m) {
  ZC_ASSIGN(const CameraPath samples, read_camera_path(path));
  if (frame >= samples.size())
    return Error{ErrorCode::kArgument,
                 "--frame " + std::to_string(frame) + " of a path of " + std::to_string(samples.size()) + " samples"};
  CameraSample sample = samples[frame];
  sample.eye += offset_m;
  sample.target += offset_m;
  return sample;
}

}  // namespace

Result<Subject> open_subject(const SubjectOptions& o) {
  const double step_m = std::ldexp(1.0, kDefaultStepLog2);
  const glm::dvec3 offset_m(o.world_offset_m, o.world_offset_m, 0);
  Subject subject;
  std::optional<CrsPoint> origin;
  TemporaryFolder folder;
  std::string path = o.path;
  const bool generated = o.world.empty() && o.triangles.empty();
  if (generated) {
    ZC_TRY(folder.create());
    ZC_TRY(generate_city({.size_km = o.size_km}, folder.path()));
    if (path.empty()) path = (folder.path() / "shots.json").string();
  }
  if (o.camera) {
    ZC_ASSIGN(subject.camera, read_camera(path, o.frame, offset_m));
    ZC_ASSIGN(origin, lattice_point(subject.camera->eye, step_m));
  }
  if (!o.world.empty()) {
    WorldSceneOptions options;
    options.source = o.source;
    if (subject.camera) options.camera = &*subject.camera;
    ZC_ASSIGN(options.offset_steps, lattice_point(offset_m, step_m));
    ZC_ASSIGN(subject.scene, load_world_scene(o.world, options));
  } else if (generated) {
    const std::vector<std::filesystem::path> inputs = {folder.path() / "city.glb"};
    ZC_ASSIGN(Scene soup, import_inputs(inputs));
    for (glm::dvec3& p : soup.positions) p += offset_m;
    if (!origin) {
      ZC_ASSIGN(origin, lattice_point(offset_m, step_m));
    }
    ZC_ASSIGN(subject.scene, cut_scene("city", std::move(soup), o.leaf_triangles, origin));
  } else {
    ZC_ASSIGN(RawTriangles raw, read_triangles(o.triangles, offset_m));
    if (!origin) {
      subject.frame_m = raw.frame_m;
      Result<CrsPoint> middle = lattice_point(raw.frame_m + offset_m, step_m);
      if (!middle) return Error{middle.error().code, middle.error().message, o.triangles};
      origin = *middle;
    }
    Result<BenchScene> scene =
        cut_scene(std::filesystem::path(o.triangles).stem().string(), std::move(raw.soup), o.leaf_triangles, origin);
    if (!scene) return Error{scene.error().code, scene.error().message, o.triangles};
    subject.scene = *std::move(scene);
  }
  return subject;
}

}  // namespace zc::bench
