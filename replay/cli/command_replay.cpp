// SPDX-License-Identifier: Apache-2.0
#include <spdlog/spdlog.h>

#include <cmath>
#include <iomanip>
#include <iostream>
#include <memory>
#include <optional>
#include <thread>

#include "replay/cli/choice_option.h"
#include "replay/cli/commands.h"
#include "replay/cli/json_option.h"
#include "replay/cli/progress.h"
#include "replay/cli/world_option.h"
#include "replay/session/replay_session.h"
#include "replay/session/statistics_json.h"
#include "replay/session/units.h"
#include "replay/session/variant_cache.h"
#include "streamer/paging/memory_plan.h"

namespace zc {
namespace {

// As typed; parsed in run(), so that every fault is one line and exit code 2.
struct Arguments {
  WorldOption world;
  JsonOption json;
  ProgressOption progress;
  std::string out;
  std::vector<std::string> paths;
  std::string cap;
  std::string frames, size = "1280x720";
  std::optional<std::string> sun;
  std::string latency = "0s", bandwidth, upload_budget;
  Prediction prediction = Prediction::kPath;
  std::string host_budget = "256MiB";
  std::string device;
  std::string kernel = "auto";
  ClockKind clock = ClockKind::kVirtual;
  ReflectionMode reflections = ReflectionMode::kScreenAndProxy;
  std::vector<DebugView> debug_views;
  unsigned threads = 0;
  double tolerance = 0.002;
  double look_ahead_s = 2;
  bool no_render = false, validate = false, contact_sheet = false, leave_nothing_out = false, trace = false,
       allow_failures = false;
};

std::vector<std::string> kernel_names() {
  std::vector<std::string> names = {"auto", "measure", "packets64", "packets32", "packets16", "single"};
  for (const TraceVariant& variant : all_trace_variants()) names.push_back(trace_variant_name(variant));
  return names;
}

Status parse_kernel(const std::string& text, ReplayOptions& options) {
  options.kernel = text == "auto"      ? KernelChoice::kAuto
                   : text == "measure" ? KernelChoice::kMeasure
                                       : KernelChoice::kFixed;
  if (options.kernel != KernelChoice::kFixed) {
    options.variant_cache = variant_cache_file();
    return {};
  }
  const auto variant = parse_trace_variant(text);
  if (!variant)
    return Error{ErrorCode::kArgument, "no kernel is called '" + text + "' (auto, measure, or " +
                                           std::string(kTraceVariantNames) + ")" + did_you_mean(text, kernel_names())};
  options.renderer.trace = *variant;
  return {};
}

Result<ReplayOptions> to_options(const Arguments& a) {
  ReplayOptions options;
  options.world = a.world.place;
  ZC_ASSIGN(options.source, parse_source_options(a.world));
  options.out = a.out;
  ZC_ASSIGN(options.streamer.cap_bytes, parse_bytes(a.cap));
  options.source.held_bytes_most = index_limit_bytes(options.streamer.cap_bytes);
  ZC_ASSIGN(options.host_budget_bytes, parse_bytes(a.host_budget));
  ZC_ASSIGN(options.streamer.source_latency_s, parse_seconds(a.latency));
  if (!a.bandwidth.empty()) {
    ZC_ASSIGN(options.streamer.source_bandwidth_bytes_per_s, parse_bytes_per_second(a.bandwidth));
  }
  if (a.clock == ClockKind::kWall && (options.streamer.source_latency_s > 0 || !a.bandwidth.empty()))
    return Error{ErrorCode::kArgument, "--source-latency and --source-bandwidth need --clock virtual"};
  if (!std::isfinite(a.tolerance) || !std::isfinite(a.look_ahead_s))  // a range check lets NaN pass
    return Error{ErrorCode::kArgument, "--tolerance and --look-ahead need finite numbers"};
  if (!a.upload_budget.empty()) {
    ZC_ASSIGN(options.streamer.upload_bytes_per_frame, parse_bytes(a.upload_budget));
    if (options.streamer.upload_bytes_per_frame == 0)
      return Error{ErrorCode::kArgument, "--upload-budget is one byte at least: with none nothing is ever shown"};
  }
  if (a.trace && a.out.empty()) return Error{ErrorCode::kArgument, "--trace needs a folder for trace.json: -o"};
  if (!a.frames.empty()) {
    ZC_ASSIGN(options.frames, parse_frames(a.frames));
  }
  ZC_ASSIGN(const PictureSize size, parse_size(a.size));
  if (a.sun) {
    ZC_ASSIGN(options.sun, parse_sun(*a.sun));
  }
  ZC_TRY(parse_kernel(a.kernel, options));
  options.renderer.width = size.width;
  options.renderer.height = size.height;
  options.renderer.reflections = a.reflections;
  options.streamer.clock = a.clock;
  options.streamer.tolerance = a.tolerance;
  options.streamer.threads = a.threads != 0 ? a.threads : std::max(1U, std::thread::hardware_concurrency());
  options.look_ahead_s = a.look_ahead_s;
  options.render = !a.no_render;
  options.debug_views = a.debug_views;
  options.device = a.device;
  options.validation = a.validate;
  options.contact_sheet = a.contact_sheet;
  options.leave_nothing_out = a.leave_nothing_out;
  options.prediction = a.prediction;
  options.trace = a.trace;
  for (const std::string& path : a.paths) {
    ZC_ASSIGN(options.paths.emplace_back(), read_camera_path(path));
  }
  return options;
}

std::string counted(std::uint64_t count, const char* what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

// What the last frame asks for and could not be read: a replay in CI must not pass with coarser pages in its place.
Status check_failures(const ReplayReport& report, const std::string& world) {
  const bool is_host = report.streaming.failing.count == 0;
  const FailingNodes& failing = is_host ? report.host_failing : report.streaming.failing;
  if (failing.count == 0) return {};
  const std::string cause = failing.cause ? ", the first because " + failing.cause->describe() : "";
  return Error{ErrorCode::kIo,
               counted(failing.count, is_host ? "full-detail node" : "node") +
                   " of the last frame could not be read and coarser pages stand in" + cause +
                   "; repair the world or its server, or accept that with --allow-failures",
               world};
}

void print_summary(const ReplayReport& report) {
  const StreamerStatistics& s = report.streaming;
  std::cout << s.frames << " frames, " << s.frames_over_cap << " over the cap of " << format_bytes(s.cap_bytes)
            << "; ledger peak " << format_bytes(s.ledger.peak_bytes) << '\n'
            << s.zones_loaded << " zones loaded, " << s.zones_evicted << " evicted, " << s.requests.failed
            << " requests failed\n"
            << "wanted level in " << std::fixed << std::setprecision(1) << 100 * s.wanted_level_fraction()
            << " % of the frames; " << counted(s.failed_nodes, "node") << " failed, " << s.failing.count
            << " of them to the end\n";
  if (report.rendered_frames > 0) {
    std::cout << report.rays.total << " rays: " << report.rays.screen << " screen, " << report.rays.proxy << " proxy, "
              << report.rays.proxy_coarse << " coarse proxy, " << report.rays.sky << " sky, " << report.rays.lost
              << " lost\n"
              << "median frame " << std::fixed << std::setprecision(1) << report.total_ms << " ms on " << report.device
              << '\n';
  }
}

Status run(const Arguments& arguments) {
  ZC_ASSIGN(ReplayOptions options, to_options(arguments));
  std::optional<Progress> progress(std::in_place, arguments.progress);
  progress->update(0, "replay");
  options.progress = [&](std::uint64_t done, std::uint64_t frames) {
    progress->update(static_cast<double>(done) / static_cast<double>(frames), "replay", {done, frames, "frames"});
  };
  options.on_failure = [](const Error& error) { spdlog::warn("{}", error.describe()); };
  ZC_ASSIGN(const ReplayReport report, run_replay(options));
  progress->finish();
  progress.reset();  // its bar goes before the summary comes
  if (!arguments.json.replaces_text() && !arguments.progress.quiet) print_summary(report);
  ZC_TRY(write_json(arguments.json, statistics_text(report)));
  if (report.validation_messages > 0)
    return Error{ErrorCode::kDevice, std::to_string(report.validation_messages) + " Vulkan validation messages"};
  if (!arguments.allow_failures) ZC_TRY(check_failures(report, arguments.world.place));
  return {};
}

}  // namespace

void add_replay(CLI::App& app, const SetCommand& set) {
  const auto a = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("replay", "Page and render a world along a camera path under a memory cap");
  add_json_option(*command, a->json, add_world_option(*command, a->world));
  command
      ->add_option("--path", a->paths,
                   "Camera path (CSV) or still views (shots.json) [a flight over the world]; several: so many cameras "
                   "under one cap")
      ->expected(1)
      ->take_all();
  command->add_option("--cap", a->cap, "Hard cap on all memory of the streamer, e.g. 64MiB")->required();
  command->add_option("-o,--output", a->out, "Folder for frames, stats.json and frames.csv");
  command->add_option("--frames", a->frames, "Path samples A (inclusive) to B (exclusive): A:B, A:B:STEP or all");
  command->add_option("--size", a->size, "Picture size")->capture_default_str();
  command->add_flag("--no-render", a->no_render, "Page only: no device, no pictures");
  add_choice_option<ReflectionMode>(
      *command, "--reflections", a->reflections,
      {{"ssr+proxy", ReflectionMode::kScreenAndProxy},
       {"proxy", ReflectionMode::kProxy},
       {"full", ReflectionMode::kFull},
       {"none", ReflectionMode::kNone}},
      "ssr+proxy: screen first, then proxies; proxy: proxies only; full: full detail; none: sky only", "ssr+proxy");
  add_choice_option<DebugView>(*command, "--debug-views", a->debug_views,
                               {{"provenance", DebugView::kProvenance},
                                {"bvh", DebugView::kBvh},
                                {"normals", DebugView::kNormals},
                                {"depth", DebugView::kDepth}},
                               "Also write these, per frame; separated by commas")
      ->delimiter(',')
      ->option_text("provenance,bvh,normals,depth");
  command->add_flag("--contact-sheet", a->contact_sheet, "Also write contact_sheet.png: twelve frames on one picture");
  command->add_option("--sun", a->sun,
                      "Sun: azimuth (degrees clockwise from north), elevation [the world's, else 145,38]");
  add_choice_option<ClockKind>(*command, "--clock", a->clock,
                               {{"virtual", ClockKind::kVirtual}, {"wall", ClockKind::kWall}},
                               "virtual: same path, same log; wall: measures this machine", "virtual");
  command->add_option("--source-latency", a->latency, "Modelled source: latency of a request (virtual clock)")
      ->capture_default_str();
  command->add_option("--source-bandwidth", a->bandwidth, "Modelled source: bandwidth, e.g. 20MB/s [unlimited]");
  command->add_option("--threads", a->threads, "Streaming threads (0: all cores)")
      ->capture_default_str()
      ->check(CLI::Range(0U, 256U));
  command->add_option("--tolerance", a->tolerance, "Refine where a proxy's error exceeds this share of its distance")
      ->capture_default_str()
      ->check(CLI::Range(1e-6, 1.0));
  command->add_option("--look-ahead", a->look_ahead_s, "Seconds of the path that paging looks ahead")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 60.0));
  add_choice_option<Prediction>(
      *command, "--prediction", a->prediction, {{"path", Prediction::kPath}, {"velocity", Prediction::kVelocity}},
      "What paging looks ahead along: the path itself, or each camera's velocity, as for a live camera", "path");
  command->add_option("--upload-budget", a->upload_budget, "Bytes of pages that a frame may upload [unlimited]");
  command->add_flag("--trace", a->trace,
                    "Also write trace.json: what paging did and when, for Perfetto or chrome://tracing");
  command->add_option("--host-budget", a->host_budget, "Memory of the zones drawn in full detail, outside the cap")
      ->capture_default_str();
  command->add_option("--device", a->device, "Part of the Vulkan device's name");
  command
      ->add_option(
          "--kernel", a->kernel,
          "How rays are traced; same pictures by all. auto, measure (again), or packets64|32|16 or single, then "
          "+texels|+storage, +shared, +w32|+w128")
      ->capture_default_str();
  command->add_flag("--validate", a->validate,
                    "Vulkan validation layers with synchronisation validation; exit 1 when they report anything");
  command->add_flag("--allow-failures", a->allow_failures,
                    "Exit code 0 although pages that the last frame asks for could not be read");
  command->add_flag("--leave-nothing-out", a->leave_nothing_out, "Run the general pipeline, to measure what is saved");
  add_progress_options(*command, a->progress);
  command->callback([=] { set([=] { return run(*a); }); });
}

}  // namespace zc
