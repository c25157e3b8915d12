// SPDX-License-Identifier: Apache-2.0
#include <spdlog/spdlog.h>

#include <cmath>
#include <glm/common.hpp>
#include <map>
#include <memory>
#include <optional>

#include "baker/bake.h"
#include "baker/bvh/build_page.h"
#include "baker/cut.h"
#include "baker/generate/city.h"
#include "baker/import/import.h"
#include "baker/snap.h"
#include "base/file.h"
#include "replay/bench/bench_scene.h"
#include "replay/bench/print_figures.h"
#include "replay/bench/trace_bench.h"
#include "replay/bvh_option.h"
#include "replay/commands.h"
#include "replay/progress.h"
#include "replay/temporary_folder.h"
#include "replay/units.h"

namespace zc {
namespace {

using bench::BenchRay;
using bench::BenchScene;
using bench::CrsPoint;

struct Arguments {
  std::string world, path, rays, triangles;
  std::uint64_t frame = 0;
  std::string size = "1280x720";
  bench::PixelOrder order = bench::PixelOrder::kRows;
  bench::TraceBenchOptions options;
  double world_offset_m = 0;
  BvhMethod bvh = BvhMethod::kAuto;
  std::string json, dump_rays, dump_triangles;
};

// Raw triangles within this of zero are exact in floats as they are; others are traced around a whole metre in their
// middle.
constexpr double kPlainFrameM = 32768;

// Snaps and cuts as a bake does, without proxies.
Result<BenchScene> cut_scene(std::string name, Scene&& soup, const std::optional<CrsPoint>& origin) {
  ZC_ASSIGN(SnappedScene snapped, snap_scene(std::move(soup), kDefaultStepLog2));
  ZoneTree tree = cut_zones(snapped, BakeOptions{}.leaf_triangles);
  for (const ImportCount& note : snapped.notes) spdlog::info("{}: {}", note.what, note.count);
  bench::SceneAssembly assembly(std::move(name), origin.value_or(snapped.anchor), std::ldexp(1.0, kDefaultStepLog2));
  for (Zone& zone : tree.zones) {
    if (zone.detail.faces.empty()) continue;
    const std::uint32_t shift = step_shift_for_box(bounds_of(zone.detail));
    round_to_step(zone.detail, shift);
    assembly.begin_zone(shift);
    for (const LatticeFace& face : zone.detail.faces) {
      std::array<CrsPoint, 3> corners;
      for (std::size_t i = 0; i < 9; ++i)
        corners[i / 3][i % 3] = snapped.anchor[i % 3] + zone.detail.vertices[face.v[i / 3]][i % 3];
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
  ZC_ASSIGN(const bench::RawRecords records, bench::read_raw_records(file, 9));
  if (records.values.empty()) return Error{ErrorCode::kFormat, "holds no triangle", file};
  if (records.dropped > 0)
    spdlog::warn("{}: {} triangles with values that are no numbers or beyond 1.8e18, dropped", file, records.dropped);
  RawTriangles raw;
  glm::dvec3 low(INFINITY), high(-INFINITY);
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

// A scene and what its rays come from.
struct Subject {
  BenchScene scene;
  std::optional<CameraSample> camera;
  glm::dvec3 frame_m = {};  // the local origin in the frame of --rays
};

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

Result<Subject> open_subject(const Arguments& a) {
  const double step_m = std::ldexp(1.0, kDefaultStepLog2);
  const glm::dvec3 offset_m(a.world_offset_m, a.world_offset_m, 0);
  Subject subject;
  std::optional<CrsPoint> origin;
  TemporaryFolder folder;
  std::string path = a.path;
  const bool generated = a.world.empty() && a.triangles.empty();
  if (generated) {
    ZC_TRY(folder.create());
    ZC_TRY(generate_city({}, folder.path()));
    if (path.empty()) path = (folder.path() / "shots.json").string();
  }
  if (a.rays.empty()) {
    ZC_ASSIGN(subject.camera, read_camera(path, a.frame, offset_m));
    ZC_ASSIGN(origin, bench::lattice_point(subject.camera->eye, step_m));
  }
  if (!a.world.empty()) {
    bench::WorldSceneOptions options;
    if (subject.camera) options.camera = &*subject.camera;
    ZC_ASSIGN(options.offset_steps, bench::lattice_point(offset_m, step_m));
    ZC_ASSIGN(subject.scene, bench::load_world_scene(a.world, options));
  } else if (generated) {
    const std::vector<std::filesystem::path> inputs = {folder.path() / "city.glb"};
    ZC_ASSIGN(Scene soup, import_inputs(inputs, {}));
    for (glm::dvec3& p : soup.positions) p += offset_m;
    if (!origin) {
      ZC_ASSIGN(origin, bench::lattice_point(offset_m, step_m));
    }
    ZC_ASSIGN(subject.scene, cut_scene("city", std::move(soup), origin));
  } else {
    ZC_ASSIGN(RawTriangles raw, read_triangles(a.triangles, offset_m));
    if (!origin) {
      subject.frame_m = raw.frame_m;
      Result<CrsPoint> middle = bench::lattice_point(raw.frame_m + offset_m, step_m);
      if (!middle) return Error{middle.error().code, middle.error().message, a.triangles};
      origin = *middle;
    }
    Result<BenchScene> scene =
        cut_scene(std::filesystem::path(a.triangles).stem().string(), std::move(raw.soup), origin);
    if (!scene) return Error{scene.error().code, scene.error().message, a.triangles};
    subject.scene = *std::move(scene);
  }
  return subject;
}

Result<std::vector<BenchRay>> take_rays(const Arguments& a, const Subject& subject, const bench::Oracle& oracle) {
  if (subject.camera) {
    ZC_ASSIGN(const PictureSize size, parse_size(a.size));
    return bench::make_mirror_rays(oracle, subject.scene, *subject.camera,
                                   {size.width, size.height, a.order, a.options.threads});
  }
  ZC_ASSIGN(bench::RaySet set, bench::read_rays(a.rays, subject.frame_m));
  if (set.dropped > 0)
    spdlog::warn("{}: {} rays with values that are no numbers or beyond 1.8e18, dropped", a.rays, set.dropped);
  return std::move(set.rays);
}

bench::PageBuilder page_builder(BvhMethod method) {
  BvhBuildOptions options;
  options.method = method;
  return [options](const ZoneMesh& mesh, NodeRecord& node) -> Result<bench::ZonePage> {
    ZC_ASSIGN(BuiltPage page, build_page(mesh, options, 1, node, "page"));
    return bench::ZonePage{std::move(page.words), std::move(page.bvh.order)};
  };
}

Status check(const Arguments& a) {
  if (!a.world.empty() && !a.triangles.empty())
    return Error{ErrorCode::kArgument, "a world and --triangles: one of them names the scene"};
  if (!a.rays.empty() && !a.path.empty())
    return Error{ErrorCode::kArgument, "--rays and --path: one of them, not both"};
  if (a.rays.empty() && a.path.empty() && !(a.world.empty() && a.triangles.empty()))
    return Error{ErrorCode::kArgument, "a scene of yours needs --path or --rays"};
  if (!std::isfinite(a.world_offset_m))  // a range check lets NaN pass
    return Error{ErrorCode::kArgument, "--world-offset needs a finite number"};
  if (Result<PictureSize> size = parse_size(a.size); !size) return std::move(size).error();
  return bench::check_engine_names(a.options.engines);
}

Status run(const Arguments& a) {
  ZC_TRY(check(a));
  ZC_ASSIGN(const Subject subject, open_subject(a));
  const bench::Oracle oracle(subject.scene.triangles);
  ZC_ASSIGN(const std::vector<BenchRay> rays, take_rays(a, subject, oracle));
  if (!a.dump_rays.empty()) ZC_TRY(write_file(a.dump_rays, std::as_bytes(std::span(rays))));
  if (!a.dump_triangles.empty())
    ZC_TRY(write_file(a.dump_triangles, std::as_bytes(std::span(subject.scene.triangles))));
  bench::TraceBenchOptions options = a.options;
  options.page_builder = page_builder(a.bvh);
  std::optional<Progress> progress(std::in_place);
  options.progress = [&](double fraction, std::string_view stage) { progress->update(fraction, stage); };
  ZC_ASSIGN(const bench::TraceBenchReport report, bench::run_trace_bench(subject.scene, oracle, rays, options));
  progress.reset();  // its line goes before the table comes
  return bench::print_figures(bench::trace_table(report), bench::trace_json(report), a.json);
}

void add_trace(CLI::App& app, const SetCommand& set) {
  const auto a = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "trace", "Trace the same rays through our kernels and every peer, and hold all hits against double precision");
  command->add_option("world", a->world, "World folder; without it and --triangles: the generated city");
  command->add_option("--path", a->path, "Camera path or still views: mirror rays of what the camera sees");
  command->add_option("--frame", a->frame, "Sample of the path")->capture_default_str();
  command->add_option("--rays", a->rays,
                      "Raw floats, six a ray: ox oy oz dx dy dz; those of a world are relative to its anchor");
  command->add_option("--triangles", a->triangles, "Raw floats, nine a triangle");
  command->add_option("--size", a->size, "Picture size that mirror rays come from")->capture_default_str();
  command->add_option("--order", a->order, "Order of the picture's rays")
      ->transform(CLI::CheckedTransformer(std::map<std::string, bench::PixelOrder>{
          {"rows", bench::PixelOrder::kRows}, {"tiles", bench::PixelOrder::kTiles}}))
      ->option_text("rows|tiles [rows]");
  command->add_option("--engines", a->options.engines, "Parted by commas; default: all that this machine has")
      ->delimiter(',');
  command->add_option("--repeat", a->options.repeat, "Timed runs of each engine, in turn")
      ->capture_default_str()
      ->check(CLI::Range(1U, 1000U));
  command->add_option("--threads", a->options.threads, "Threads of the engines that run on the CPU")
      ->capture_default_str()
      ->check(CLI::Range(1U, 256U));
  command->add_option("--device", a->options.device, "Part of the Vulkan device's name");
  command->add_option("--world-offset", a->world_offset_m, "Move the scene so many metres east and north")
      ->capture_default_str()
      ->check(CLI::Range(-1e8, 1e8));
  add_bvh_option(*command, a->bvh, "How our own engines build");
  command->add_option("--json", a->json, "Write the figures to this file, or to standard output: -");
  command->add_option("--dump-rays", a->dump_rays, "Write the rays as raw floats");
  command->add_option("--dump-triangles", a->dump_triangles, "Write the triangles as raw floats");
  command->callback([=] { set([=] { return run(*a); }); });
}

}  // namespace

void add_bench(CLI::App& app, const SetCommand& set) {
  CLI::App* command = app.add_subcommand("bench", "Measure against peers, in one run, on the same data");
  command->require_subcommand(1);
  add_trace(*command, set);
  add_bench_top_level(*command, set);
}

}  // namespace zc
