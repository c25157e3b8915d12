// SPDX-License-Identifier: Apache-2.0
#include "replay/session/replay_drawing.h"

#include <algorithm>
#include <string>
#include <utility>

#include "replay/paths/frame_camera.h"

namespace zc {
namespace {

// The host draws full detail wherever a third of a pixel at 720 lines would show the difference.
constexpr double kHostTolerance = 0.0004;
constexpr const char* kNoMirror = "no material of this world mirrors";

}  // namespace

Result<std::unique_ptr<ReplayDrawing>> ReplayDrawing::open(const ReplayOptions& options, Device& device, Source& source,
                                                           const PagedScene& proxies) {
  std::unique_ptr<ReplayDrawing> drawing(new ReplayDrawing(options, device, proxies));
  ZC_TRY(drawing->open_full_detail(source));
  ZC_TRY(drawing->open_host());
  return drawing;
}

// At once, whatever the modelled source does to the reflections' pages.
Status ReplayDrawing::open_full_detail(Source& source) {
  StreamerOptions paging;
  paging.cap_bytes = options_.host_budget_bytes;
  paging.threads = options_.streamer.threads;
  paging.tolerance = kHostTolerance;
  paging.include_detail = true;
  paging.on_failure = options_.on_failure;
  Status opened = full_detail_.open(source, options_.world, paging);
  if (opened) return {};
  Error error = std::move(opened).error();
  if (error.code == ErrorCode::kBudget) error.message = "--host-budget: " + error.message;
  return error;
}

Status ReplayDrawing::open_host() {
  const IndexView index = proxies_.index();
  HostOptions host = options_.renderer;
  fit_to_world(host, index, options_.sun);
  if (options_.leave_nothing_out) host.sun_is_baked = false;
  sun_is_baked_ = host.sun_is_baked;
  mirrors_ =
      std::ranges::any_of(index.materials, [&](const MaterialRecord& m) { return m.roughness < host.roughness_cut; });
  if (!mirrors_ && options_.renderer.reflections != ReflectionMode::kNone)
    options_.warn({ErrorCode::kArgument,
                   std::string(kNoMirror) + ", so no ray is traced; bake it with --wet or --materials",
                   options_.world.string()});
  if (!mirrors_ && !options_.leave_nothing_out) host.reflections = ReflectionMode::kNone;
  host.leave_nothing_out = options_.leave_nothing_out;
  kernels_.emplace(options_, VariantKey{device_.name(), device_.driver()}, host.reflections != ReflectionMode::kNone);
  host.trace = kernels_->first(
      trace_limits(device_, host.page_depth, proxies_.zones().top_depth_bound(), proxies_.zones().all_as_texels()));
  ZC_ASSIGN(scene_, RenderedScene::create(device_, proxies_, full_detail_, host));
  return {};
}

Result<FrameResult> ReplayDrawing::draw_frame(std::uint64_t frame, const std::vector<CameraSample>& cameras,
                                              ReplayFiles* files, ReplayStatistics& statistics) {
  ZC_TRY(full_detail_.advance(views_of(cameras), cameras.front().time_s));
  std::vector<FrameResult> pictures;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    ZC_ASSIGN(const FrameCamera camera, make_camera(proxies_.index(), cameras[c]));
    ZC_ASSIGN(const FrameResult picture, scene_->draw(camera, !options_.leave_nothing_out));
    statistics.add_picture(picture);
    if (files != nullptr) ZC_TRY(save_pictures(frame, c, cameras[c], camera, *files));
    kernels_->after_frame(scene_->host(), picture.counters);
    pictures.push_back(picture);
  }
  return sum_of(pictures);
}

Status ReplayDrawing::save_pictures(std::uint64_t frame, std::size_t which, const CameraSample& sample,
                                    const FrameCamera& camera, ReplayFiles& files) {
  const std::string name = frame_name(sample, frame);
  ZC_TRY(files.save_picture(scene_->picture(), which, name));
  for (const DebugView view : options_.debug_views) {
    ZC_TRY(scene_->draw_debug(view, camera));
    ZC_TRY(files.save_debug_view(scene_->picture(), which, view, name));
  }
  return {};
}

void ReplayDrawing::describe(ReplayReport& report) {
  const StreamerStatistics full_detail = full_detail_.streamer().statistics();
  report_pool_limit("full detail: ", full_detail, report);
  report.host_failing = full_detail.failing;
  report.host_bytes = full_detail.ledger.peak_bytes;
  report.device = device_.name();
  report.driver = device_.driver();
  report.validation_messages = device_.validation_messages();
  report.trace_variant = trace_variant_name(scene_->host().trace_variant());
  report.trace_variant_origin = kernels_->origin();
  report.measure_ms = kernels_->measure_ms();
  if (options_.leave_nothing_out) return;
  report.left_out.emplace_back("gbuffer: zones outside the view");
  if (sun_is_baked_) report.left_out.emplace_back("shadow rays: where the bake says what the sun lights");
  report.left_out.emplace_back("filter: every mirror is exactly specular");
  for (const LeftOutPass& left : scene_->host().left_out())
    report.left_out.push_back(left.passes + ": " + (mirrors_ ? left.reason : kNoMirror));
}

}  // namespace zc
