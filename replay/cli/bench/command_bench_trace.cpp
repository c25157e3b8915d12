// SPDX-License-Identifier: Apache-2.0
#include <spdlog/spdlog.h>

#include <cmath>
#include <iostream>
#include <memory>
#include <optional>

#include "baker/bvh/build_page.h"
#include "base/file.h"
#include "replay/bench/trace_bench.h"
#include "replay/cli/bench/bench_subject.h"
#include "replay/cli/bvh_option.h"
#include "replay/cli/choice_option.h"
#include "replay/cli/commands.h"
#include "replay/cli/json_option.h"
#include "replay/cli/progress.h"
#include "replay/cli/world_option.h"
#include "replay/session/units.h"

namespace zc {
namespace {

using bench::BenchRay;
using bench::Subject;

struct Arguments {
  WorldOption world;
  bench::SubjectOptions subject;
  std::string rays;
  std::string size = "1280x720";
  bench::PixelOrder order = bench::PixelOrder::kTiles;
  bench::TraceBenchOptions options;
  BvhMethod bvh = BvhMethod::kAuto;
  JsonOption json;
  std::string dump_rays, dump_triangles;
};

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
    ZC_ASSIGN(BuiltPage page, build_page(mesh, {}, options, 1, node, "page"));
    return bench::ZonePage{std::move(page.words), std::move(page.bvh.order)};
  };
}

Status check(const Arguments& a) {
  if (!a.world.place.empty() && !a.subject.triangles.empty())
    return Error{ErrorCode::kArgument, "a world and --triangles: one of them names the scene"};
  if (!a.rays.empty() && !a.subject.path.empty())
    return Error{ErrorCode::kArgument, "--rays and --path: one of them, not both"};
  if (a.rays.empty() && a.subject.path.empty() && !(a.world.place.empty() && a.subject.triangles.empty()))
    return Error{ErrorCode::kArgument, "a scene of yours needs --path or --rays"};
  if (!std::isfinite(a.subject.world_offset_m))  // a range check lets NaN pass
    return Error{ErrorCode::kArgument, "--world-offset needs a finite number"};
  if (Result<PictureSize> size = parse_size(a.size); !size) return std::move(size).error();
  return bench::check_engine_names(a.options.engines);
}

Status run(const Arguments& a) {
  ZC_TRY(check(a));
  bench::SubjectOptions source = a.subject;
  source.world = a.world.place;
  ZC_ASSIGN(source.source, parse_source_options(a.world));
  source.camera = a.rays.empty();
  ZC_ASSIGN(const Subject subject, bench::open_subject(source));
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
  if (!a.json.replaces_text()) std::cout << bench::trace_table(report);
  return write_json(a.json, bench::trace_json(report).dump(2));
}

}  // namespace

void add_bench_trace(CLI::App& app, const SetCommand& set) {
  const auto a = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "trace", "Trace the same rays through our kernels and every peer, and compare all hits with double precision");
  add_world_option(*command, a->world, "without it and --triangles: the generated city");
  command->add_option("--path", a->subject.path, "Camera path or still views: mirror rays of what the camera sees");
  command->add_option("--frame", a->subject.frame, "Sample of the path")->capture_default_str();
  command->add_option("--rays", a->rays,
                      "Raw floats, six a ray: ox oy oz dx dy dz; those of a world are relative to its anchor");
  command->add_option("--triangles", a->subject.triangles, "Raw floats, nine a triangle");
  command->add_option("--size", a->size, "Picture size that mirror rays come from")->capture_default_str();
  add_choice_option<bench::PixelOrder>(*command, "--order", a->order,
                                       {{"rows", bench::PixelOrder::kRows}, {"tiles", bench::PixelOrder::kTiles}},
                                       "Order of the picture's rays", "tiles");
  command->add_option("--engines", a->options.engines, "Separated by commas; default: all that this machine has")
      ->delimiter(',');
  command->add_option("--repeat", a->options.repeat, "Timed runs of each engine, in turn")
      ->capture_default_str()
      ->check(CLI::Range(1U, 1000U));
  command->add_flag("--any-hit", a->options.any_hit, "Ask only whether a ray hits something, not what it hits first");
  command->add_option("--threads", a->options.threads, "Threads of the engines that run on the CPU")
      ->capture_default_str()
      ->check(CLI::Range(1U, 256U));
  command->add_option("--device", a->options.device, "Part of the Vulkan device's name");
  command->add_option("--world-offset", a->subject.world_offset_m, "Move the scene so many metres east and north")
      ->capture_default_str()
      ->check(CLI::Range(-1e8, 1e8));
  add_bvh_option(*command, a->bvh, "How our own engines build");
  add_json_option(*command, a->json);
  command->add_option("--dump-rays", a->dump_rays, "Write the rays as raw floats");
  command->add_option("--dump-triangles", a->dump_triangles, "Write the triangles as raw floats");
  command->callback([=] { set([=] { return run(*a); }); });
}

}  // namespace zc
