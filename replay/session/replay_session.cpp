// SPDX-License-Identifier: Apache-2.0
#include "replay/session/replay_session.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <memory>
#include <optional>
#include <thread>

#include "base/file.h"
#include "base/platform.h"
#include "replay/host/zone_draws.h"
#include "replay/image/png_file.h"
#include "replay/session/frame_log.h"
#include "replay/session/render_setup.h"
#include "replay/session/trace_file.h"
#include "replay/session/variant_cache.h"
#include "replay/session/world_tour.h"
#include "runtime/scene/zone_set.h"
#include "streamer/open_source.h"
#include "streamer/paging/heap_page_sink.h"
#include "streamer/paging/look_ahead.h"
#include "streamer/statistics/belady.h"

namespace zc {
namespace {

constexpr std::uint32_t kLookAheadViews = 8;
constexpr std::size_t kSheetTiles = 12;
// The host draws full detail wherever a third of a pixel at 720 lines would show the difference.
constexpr double kHostTolerance = 0.0004;
// What is kept of the frames' selections for what an eviction that knows the future would have read: 4 MiB.
constexpr std::size_t kTraceMostWords = 1U << 20U;
// A replay that was not asked to measure begins no further step after this.
constexpr double kMeasureMs = 2000;

constexpr std::array kDebugViews = {DebugView::kProvenance, DebugView::kBvh, DebugView::kNormals, DebugView::kDepth};

const char* debug_name(DebugView view) {
  switch (view) {
    case DebugView::kProvenance:
      return "provenance";
    case DebugView::kBvh:
      return "bvh";
    case DebugView::kNormals:
      return "normals";
    case DebugView::kDepth:
      return "depth";
  }
  return "";
}

double median(std::vector<double>& values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

// Everything that draws; absent in --no-render.
struct Drawing {
  std::unique_ptr<Device> device;
  std::optional<ZoneSet> proxies, host;
  std::unique_ptr<Streamer> host_streamer;
  std::unique_ptr<StandInHost> renderer;
};

class Session {
 public:
  explicit Session(const ReplayOptions& options) : options_(options), paths_(options.paths) {}

  Result<ReplayReport> run() {
    ZC_ASSIGN(source_, open_source(options_.world, options_.source));
    if (options_.render) ZC_TRY(open_device());
    reset_peak_resident_set();
    report_.baseline_rss_bytes = resident_set_bytes();
    ZC_TRY(open_world());
    if (paths_.empty()) {
      ZC_ASSIGN(paths_.emplace_back(), tour_of(*source_, streamer_->index()));
    }
    ZC_TRY(check_path());
    if (!options_.out.empty()) ZC_TRY(open_files());
    ZC_TRY(replay_frames());
    return finish();
  }

 private:
  Status open_device() {
    ZC_ASSIGN(drawing_.device, Device::create({options_.device, options_.validation}));
    drawing_.proxies.emplace(*drawing_.device);
    drawing_.host.emplace(*drawing_.device);
    report_.device = drawing_.device->name();
    report_.driver = drawing_.device->driver();
    return {};
  }

  // The streamer knows files by their names in the world; a person needs to know which world.
  Result<std::unique_ptr<Streamer>> in_world(Result<std::unique_ptr<Streamer>> opened) const {
    if (opened.ok()) return opened;
    Error error = std::move(opened).error();
    const std::filesystem::path place(error.path);
    if (place.is_relative() && !is_url(error.path) && !error.path.starts_with(options_.world.string()))
      error.path = (error.path.empty() ? options_.world : options_.world / place).string();
    return error;
  }

  Status open_world() {
    StreamerOptions paging = options_.streamer;
    paging.on_failure = options_.on_failure;
    if (!options_.render) {
      ZC_ASSIGN(streamer_, in_world(Streamer::open(*source_, paging, heap_sink_)));
      return {};
    }
    ZC_ASSIGN(streamer_, in_world(Streamer::open(*source_, paging, *drawing_.proxies)));

    // The host's own scene: full detail at once, whatever the modelled source does to the reflections' pages.
    StreamerOptions host;
    host.cap_bytes = options_.host_budget_bytes;
    host.threads = options_.streamer.threads;
    host.tolerance = kHostTolerance;
    host.include_detail = true;
    host.on_failure = options_.on_failure;
    auto host_streamer = in_world(Streamer::open(*source_, host, *drawing_.host));
    if (!host_streamer) {
      Error error = std::move(host_streamer).error();
      if (error.code == ErrorCode::kBudget) error.message = "--host-budget: " + error.message;
      return error;
    }
    drawing_.host_streamer = std::move(host_streamer).value();

    const WorldIndex& index = streamer_->index();
    const std::vector<gpu::MaterialEntry> materials = material_entries(index);
    mirrors_ = std::ranges::any_of(
        index.materials, [&](const MaterialRecord& m) { return m.roughness < options_.renderer.roughness_cut; });
    HostOptions renderer = options_.renderer;
    set_sun(renderer, index, options_.sun);
    if (options_.leave_nothing_out) renderer.sun_is_baked = false;
    sun_is_baked_ = renderer.sun_is_baked;
    renderer.page_depth = deepest_page(index);
    if (!mirrors_ && !options_.leave_nothing_out) renderer.reflections = ReflectionMode::kNone;
    renderer.leave_nothing_out = options_.leave_nothing_out;
    pick_kernels(renderer);
    ZC_ASSIGN(drawing_.renderer,
              StandInHost::create(*drawing_.device, *drawing_.proxies, *drawing_.host, materials, renderer));
    return {};
  }

  // Those to begin with; the choice is final unless there is something to measure.
  void pick_kernels(HostOptions& renderer) {
    const TraceLimits limits = trace_limits(*drawing_.device, renderer.page_depth, drawing_.proxies->top_depth_bound(),
                                            drawing_.proxies->all_as_texels());
    report_.trace_variant_origin = "fixed";
    if (options_.kernel != KernelChoice::kFixed) {
      std::optional<TraceVariant> cached;
      if (options_.kernel == KernelChoice::kAuto) cached = read_cached_variant(options_.variant_cache, variant_key());
      if (cached && !unsupported_reason(*cached, limits).empty()) cached.reset();  // another world's
      renderer.trace = cached.value_or(TraceVariant{});
      report_.trace_variant_origin = cached ? "cached" : "default";
      // Not unasked where a wall clock paces the frames: those behind would be measured with it.
      const bool paced = options_.streamer.clock == ClockKind::kWall && options_.kernel == KernelChoice::kAuto;
      measure_kernels_ = !cached && !paced && renderer.reflections != ReflectionMode::kNone;
    }
    const std::string_view why_not = unsupported_reason(renderer.trace, limits);
    if (why_not.empty()) return;
    renderer.trace = nearest_fit(renderer.trace, limits);
    warn({ErrorCode::kDevice, "traced by " + trace_variant_name(renderer.trace) + ": " + std::string(why_not)});
  }

  // After a frame: on its own rays and zones, which are what this device will have to trace.
  void measure_kernels(const FrameResult& frame) {
    if (!measure_kernels_ || frame.counters.ray_count < TraceQueue::kRaysToChoose) return;
    measure_kernels_ = false;
    const auto started = std::chrono::steady_clock::now();
    const double budget_ms = options_.kernel == KernelChoice::kAuto ? kMeasureMs : INFINITY;
    const Result<bool> complete = drawing_.renderer->choose_trace_variant(frame.counters.ray_count, budget_ms);
    const auto took = std::chrono::steady_clock::now() - started;
    started_ += took;
    if (!complete) return warn(complete.error());  // a driver that refuses one kernel may still take the others
    report_.measure_ms = std::chrono::duration<double, std::milli>(took).count();
    report_.trace_variant_origin = "measured";
    if (options_.variant_cache.empty() || !*complete) return;  // the next replay finds more of them compiled
    if (Status kept = write_cached_variant(options_.variant_cache, variant_key(), drawing_.renderer->trace_variant());
        !kept.ok())
      warn(kept.error());
  }

  [[nodiscard]] VariantKey variant_key() const { return {report_.device, report_.driver}; }

  void warn(const Error& error) const {
    if (options_.on_failure) options_.on_failure(error);
  }

  // Before anything is written: a path must not turn out to be useless after an hour.
  Status check_path() const {
    const std::uint64_t end = last_frame();
    if (options_.frames.begin >= end)
      return Error{ErrorCode::kArgument,
                   "the path has " + std::to_string(lead().size()) + " samples, none of them in the frames asked for"};
    const double aspect = static_cast<double>(options_.renderer.width) / options_.renderer.height;
    bool seen = false;
    for (std::uint64_t frame = options_.frames.begin; frame < end; ++frame) {
      for (const CameraSample& sample : cameras_of(frame)) {
        if (const auto camera = make_camera(streamer_->index(), sample); !camera) return camera.error();
        if (!seen) {
          ZC_ASSIGN(seen, looks_at_world(streamer_->index(), sample, aspect));
        }
      }
    }
    if (!seen) warn(nothing_seen(streamer_->index(), lead()[options_.frames.begin]));
    return {};
  }

  [[nodiscard]] const CameraPath& lead() const { return paths_.front(); }

  [[nodiscard]] std::uint64_t last_frame() const {  // exclusive
    return std::min<std::uint64_t>(options_.frames.end, lead().size());
  }

  // Every camera in a frame.
  [[nodiscard]] std::vector<CameraSample> cameras_of(std::uint64_t frame) const {
    std::vector<CameraSample> cameras = {lead()[frame]};
    for (std::size_t c = 1; c < paths_.size(); ++c) cameras.push_back(camera_at(paths_[c], cameras.front().time_s));
    return cameras;
  }

  // Where a camera's pictures go: the first one's lie where those of a single one would.
  [[nodiscard]] std::filesystem::path pictures_of(std::size_t camera) const {
    return camera == 0 ? options_.out : options_.out / ("camera_" + std::to_string(camera));
  }

  // Only what a replay writes, whatever its options.
  Status remove_earlier_pictures() const {
    std::error_code code;
    for (std::size_t c = 0; c == 0 || std::filesystem::is_directory(pictures_of(c), code); ++c) {
      ZC_TRY(remove_written_pngs(pictures_of(c) / "frames"));
      for (const DebugView view : kDebugViews) ZC_TRY(remove_written_pngs(pictures_of(c) / debug_name(view)));
      if (c > 0) std::filesystem::remove(pictures_of(c), code);  // where nothing else is in it
    }
    return remove_written_png(options_.out / "contact_sheet.png");
  }

  Status open_files() {
    std::vector<std::filesystem::path> folders = {options_.out};
    for (std::size_t c = 0; options_.render && c < paths_.size(); ++c) {
      folders.push_back(pictures_of(c) / "frames");
      for (const DebugView view : options_.debug_views) folders.push_back(pictures_of(c) / debug_name(view));
    }
    ZC_TRY(remove_earlier_pictures());
    for (const std::filesystem::path& folder : folders) ZC_TRY(make_folder(folder));
    ZC_ASSIGN(log_, FrameLog::create(options_.out / "frames.csv", options_.render));
    if (options_.trace) {
      ZC_ASSIGN(trace_, TraceFile::create(options_.out / "trace.json", options_.streamer.threads));
      streamer_->observe(*trace_);
    }
    streamer_->observe(selections_);
    return {};
  }

  Status replay_frames() {
    const std::uint64_t count =
        (last_frame() - options_.frames.begin + options_.frames.step - 1) / options_.frames.step;
    started_ = std::chrono::steady_clock::now();
    const double first_s = lead()[options_.frames.begin].time_s;
    for (std::uint64_t i = 0; i < count; ++i) {
      const std::uint64_t frame = options_.frames.begin + i * options_.frames.step;
      const std::vector<CameraSample> cameras = cameras_of(frame);
      const double time_s = cameras.front().time_s;
      if (options_.streamer.clock == ClockKind::kWall)
        std::this_thread::sleep_until(started_ + std::chrono::duration<double>(time_s - first_s));
      const auto began = std::chrono::steady_clock::now();
      ZC_TRY(streamer_->advance(views_of(cameras, time_s), time_s));
      if (trace_) trace_->add_frame(frame, began, std::chrono::steady_clock::now(), streamer_->statistics());
      std::optional<FrameResult> drawn;
      if (options_.render) {
        ZC_ASSIGN(drawn, draw(cameras, time_s, frame, on_sheet(i, count)));
      }
      peak_rss_ = std::max(peak_rss_, resident_set_bytes());
      if (log_) ZC_TRY(log_->add(frame, streamer_->statistics().frame, drawn ? &*drawn : nullptr));
      if (options_.progress) options_.progress(static_cast<double>(i + 1) / static_cast<double>(count), "replay");
    }
    return {};
  }

  // Now, and where the cameras will be; a still view looks nowhere but where it is.
  std::vector<View> views_of(const std::vector<CameraSample>& cameras, double time_s) {
    std::vector<View> views;
    for (std::size_t c = 0; c < cameras.size(); ++c) {
      const glm::dvec3 eye = cameras[c].eye;
      if (!cameras[c].name.empty()) {
        views.push_back({eye});
      } else if (options_.prediction == Prediction::kVelocity) {
        const double passed_s = time_s - previous_s_;
        const bool moves = c < previous_eyes_.size() && passed_s > 0;
        const glm::dvec3 velocity = moves ? (eye - previous_eyes_[c]) / passed_s : glm::dvec3();
        extrapolate_views(eye, velocity, options_.look_ahead_s, kLookAheadViews, views);
      } else {
        views.push_back({eye});
        for (std::uint32_t i = 1; i <= kLookAheadViews && options_.look_ahead_s > 0; ++i)
          views.push_back({eye_at(paths_[c], time_s + options_.look_ahead_s * i / kLookAheadViews), i});
      }
    }
    previous_s_ = time_s;
    previous_eyes_.clear();
    for (const CameraSample& camera : cameras) previous_eyes_.push_back(camera.eye);
    return views;
  }

  // Every camera's picture; what is counted is of all of them together.
  Result<FrameResult> draw(const std::vector<CameraSample>& cameras, double time_s, std::uint64_t frame, bool sheet) {
    std::vector<View> views;
    for (const CameraSample& camera : cameras) views.push_back({camera.eye});
    ZC_TRY(drawing_.host_streamer->advance(views, time_s));
    FrameResult all;
    for (std::size_t c = 0; c < cameras.size(); ++c) {
      ZC_ASSIGN(const FrameResult one, draw_camera(cameras[c], c, frame, sheet && c == 0));
      all.counters.pixel_count += one.counters.pixel_count;
      all.counters.rays_screen += one.counters.rays_screen;
      all.counters.rays_proxy += one.counters.rays_proxy;
      all.counters.rays_proxy_coarse += one.counters.rays_proxy_coarse;
      all.counters.rays_sky += one.counters.rays_sky;
      all.counters.rays_lost += one.counters.rays_lost;
      for (std::size_t i = 0; i < kPassCount; ++i) all.pass_ms[i] += one.pass_ms[i];
      all.total_ms += one.total_ms;
    }
    return all;
  }

  Result<FrameResult> draw_camera(const CameraSample& sample, std::size_t which, std::uint64_t frame, bool sheet) {
    ZC_ASSIGN(const FrameCamera camera, make_camera(streamer_->index(), sample));
    const double aspect = static_cast<double>(options_.renderer.width) / options_.renderer.height;
    const std::vector<ZoneDraw> draws =
        zone_draws(*drawing_.host, streamer_->index(), camera, aspect, !options_.leave_nothing_out);
    ZC_ASSIGN(const FrameResult result, drawing_.renderer->render(camera, draws));
    const gpu::Counters& c = result.counters;
    report_.rays.screen += c.rays_screen;
    report_.rays.proxy += c.rays_proxy;
    report_.rays.proxy_coarse += c.rays_proxy_coarse;
    report_.rays.sky += c.rays_sky;
    report_.rays.lost += c.rays_lost;
    report_.rays.total += c.pixel_count;
    ++report_.rendered_frames;
    for (std::size_t i = 0; i < kPassCount; ++i) pass_samples_[i].push_back(result.pass_ms[i]);
    total_samples_.push_back(result.total_ms);
    if (!options_.out.empty()) ZC_TRY(save_pictures(sample, camera, pictures_of(which), frame, sheet));
    measure_kernels(result);
    return result;
  }

  Status save_pictures(const CameraSample& sample, const FrameCamera& camera, const std::filesystem::path& out,
                       std::uint64_t frame, bool sheet) {
    const double aspect = static_cast<double>(options_.renderer.width) / options_.renderer.height;

    char number[24];
    std::snprintf(number, sizeof(number), "%06llu.png", static_cast<unsigned long long>(frame));
    const std::string file = sample.name.empty() ? std::string(number) : sample.name + ".png";
    ZC_TRY(save(out / "frames" / file, options_.contact_sheet && sheet));
    for (const DebugView debug : options_.debug_views) {
      ZC_TRY(drawing_.renderer->draw_debug(debug,
                                           zone_draws(*drawing_.proxies, streamer_->index(), camera, aspect, true)));
      ZC_TRY(save(out / debug_name(debug) / file, false));
    }
    return {};
  }

  // Frames spread evenly over the replay, first and last included.
  static bool on_sheet(std::uint64_t ordinal, std::uint64_t count) {
    const std::uint64_t tiles = std::min<std::uint64_t>(kSheetTiles, count);
    if (tiles == 1) return ordinal == 0;
    for (std::uint64_t tile = 0; tile < tiles; ++tile) {
      if (ordinal == tile * (count - 1) / (tiles - 1)) return true;
    }
    return false;
  }

  Status save(const std::filesystem::path& file, bool sheet) {
    Picture picture = picture_of(*drawing_.renderer, options_.renderer);
    ZC_TRY(write_png(file, picture));
    if (sheet) tiles_.push_back(scale_down(picture, 480));
    return {};
  }

  void report_pool_limit(const std::string& set, const StreamerStatistics& paging) {
    if (!paging.pool_limited_by_sink) return;
    report_.left_out.push_back(set + "pages beyond " + std::to_string(paging.pool_bytes) +
                               " bytes: the device binds buffers of at most " +
                               std::to_string(paging.buffer_limit_bytes));
  }

  Result<ReplayReport> finish() {
    report_.streaming = streamer_->statistics();
    report_.source = source_->statistics();
    report_.optimal = optimal_paging(selections_, streamer_->index(), report_.streaming.pool_bytes);
    report_.peak_rss_bytes = std::max(peak_rss_, peak_resident_set_bytes());
    for (std::size_t i = 0; i < kPassCount; ++i) report_.pass_ms[i] = median(pass_samples_[i]);
    report_.total_ms = median(total_samples_);
    report_pool_limit("", report_.streaming);
    if (options_.render) {
      report_pool_limit("full detail: ", drawing_.host_streamer->statistics());
      report_.host_bytes = drawing_.host_streamer->statistics().ledger.peak_bytes;
      report_.validation_messages = drawing_.device->validation_messages();
      report_.trace_variant = trace_variant_name(drawing_.renderer->trace_variant());
      if (!options_.leave_nothing_out) {
        report_.left_out.emplace_back("gbuffer: zones outside the view");
        if (sun_is_baked_) report_.left_out.emplace_back("shadow rays: where the bake says what the sun lights");
        report_.left_out.emplace_back("filter: every mirror is exactly specular");
        for (const LeftOutPass& left : drawing_.renderer->left_out())
          report_.left_out.push_back(left.passes + ": " +
                                     (mirrors_ ? left.reason : "no material of this world mirrors"));
      }
    } else {
      report_.left_out.emplace_back("render: not asked for");
    }
    if (log_) ZC_TRY(log_->close());
    if (trace_) ZC_TRY(trace_->close());
    if (!tiles_.empty()) ZC_TRY(write_png(options_.out / "contact_sheet.png", make_contact_sheet(tiles_, 3, 480)));
    return std::move(report_);
  }

  const ReplayOptions& options_;
  std::vector<CameraPath> paths_;
  ReplayReport report_;
  std::unique_ptr<Source> source_;
  HeapPageSink heap_sink_;
  Drawing drawing_;
  std::unique_ptr<TraceFile> trace_;
  SelectionTrace selections_{kTraceMostWords};
  std::unique_ptr<Streamer> streamer_;
  std::optional<FrameLog> log_;
  std::vector<Picture> tiles_;
  bool mirrors_ = false;
  bool sun_is_baked_ = false;
  bool measure_kernels_ = false;                   // as soon as a frame queues rays enough
  std::chrono::steady_clock::time_point started_;  // of the path's first frame, on the wall clock
  std::uint64_t peak_rss_ = 0;
  std::vector<glm::dvec3> previous_eyes_;  // one a camera
  double previous_s_ = 0;
  std::array<std::vector<double>, kPassCount> pass_samples_;
  std::vector<double> total_samples_;
};

}  // namespace

Result<ReplayReport> run_replay(const ReplayOptions& options) { return Session(options).run(); }

}  // namespace zc
