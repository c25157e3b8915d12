// SPDX-License-Identifier: Apache-2.0
#include <spdlog/spdlog.h>

#include <cmath>
#include <iomanip>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <thread>

#include "replay/cli/choice_option.h"
#include "replay/cli/commands.h"
#include "replay/cli/json_option.h"
#include "replay/cli/progress.h"
#include "replay/cli/world_option.h"
#include "replay/session/cap_search.h"
#include "replay/session/replay_session.h"
#include "replay/session/units.h"
#include "streamer/open_source.h"
#include "streamer/paging/memory_plan.h"
#include "streamer/source/index_file.h"

namespace zc {
namespace {

constexpr std::size_t kWarningsShown = 20;

struct Arguments {
  WorldOption world;
  JsonOption json;
  std::vector<std::string> paths;
  std::string frames;
  std::vector<double> fractions = {0.5, 0.75, 0.9, 0.99, 1};
  Prediction prediction = Prediction::kPath;
  unsigned threads = 0;
  double tolerance = 0.002;
  double look_ahead_s = 2;
};

Result<ReplayOptions> to_options(const Arguments& a) {
  ReplayOptions options;
  options.world = a.world.place;
  ZC_ASSIGN(options.source, parse_source_options(a.world));
  if (!a.frames.empty()) {
    ZC_ASSIGN(options.frames, parse_frames(a.frames));
  }
  if (!std::isfinite(a.tolerance) || !std::isfinite(a.look_ahead_s))  // a range check lets NaN pass
    return Error{ErrorCode::kArgument, "--tolerance and --look-ahead need finite numbers"};
  for (const double fraction : a.fractions)
    if (!std::isfinite(fraction)) return Error{ErrorCode::kArgument, "--fractions needs finite numbers"};
  options.render = false;
  options.streamer.tolerance = a.tolerance;
  options.streamer.threads = a.threads != 0 ? a.threads : std::max(1U, std::thread::hardware_concurrency());
  options.look_ahead_s = a.look_ahead_s;
  options.prediction = a.prediction;
  for (const std::string& path : a.paths) {
    ZC_ASSIGN(options.paths.emplace_back(), read_camera_path(path));
  }
  return options;
}

struct CapRange {
  std::uint64_t smallest = 0;
  std::uint64_t largest = 0;  // all pages fit, with room to load them
};

Result<CapRange> range_of(const std::string& world, const SourceOptions& options) {
  ZC_ASSIGN(const auto source, open_source(world, options));
  ZC_ASSIGN(const WorldIndex index, read_world_index(*source, world));
  CapRange range;
  range.smallest = smallest_cap_bytes(index, source->costs());
  std::uint64_t pages = 0;
  for (const NodeRecord& node : index.nodes) pages += node.is_detail() ? 0 : node.page_bytes;
  range.largest = 4 * (range.smallest + pages);
  return range;
}

struct CapsReport {
  CapRange range;
  std::uint64_t frames = 0;
  std::vector<CapNeed> needs;
};

Result<CapsReport> measure_caps(const Arguments& arguments) {
  ZC_ASSIGN(ReplayOptions options, to_options(arguments));
  CapsReport report;
  ZC_ASSIGN(report.range, range_of(arguments.world.place, options.source));
  Progress progress;
  std::set<std::string> warnings;  // each once, whatever the number of replays
  std::uint64_t replays = 0;
  options.on_failure = [&](const Error& error) {
    if (warnings.size() < kWarningsShown && warnings.insert(error.describe()).second)
      spdlog::warn("{}", error.describe());
  };
  const auto measure = [&](std::uint64_t cap) -> Result<double> {
    options.streamer.cap_bytes = cap;
    options.source.held_bytes_most = index_limit_bytes(cap);
    const std::string stage = "replay " + std::to_string(++replays) + ", under " + format_bytes(cap);
    options.progress = [&](std::uint64_t done, std::uint64_t frames) {
      progress.update(static_cast<double>(done) / static_cast<double>(frames), stage);
    };
    ZC_ASSIGN(const ReplayReport replay, run_replay(options));
    report.frames = replay.streaming.frames;
    return replay.streaming.wanted_level_fraction();
  };
  ZC_ASSIGN(report.needs, find_caps(arguments.fractions, report.range.smallest, report.range.largest, measure));
  return report;
}

void print_table(const CapsReport& report) {
  std::cout << report.frames << " frames; smallest cap " << format_bytes(report.range.smallest) << '\n'
            << "wanted level     reached         cap       bytes\n"
            << std::fixed << std::setprecision(1);
  for (const CapNeed& need : report.needs) {
    std::cout << std::setw(10) << 100 * need.fraction << " %" << std::setw(10) << 100 * need.reached << " %";
    if (need.cap_bytes)
      std::cout << std::setw(12) << format_bytes(*need.cap_bytes) << std::setw(12) << *need.cap_bytes << '\n';
    else
      std::cout << std::setw(12) << "none" << '\n';
  }
}

std::string to_json(const CapsReport& report) {
  nlohmann::ordered_json json = {{"frames", report.frames},
                                 {"smallest_cap_bytes", report.range.smallest},
                                 {"caps", nlohmann::ordered_json::array()}};
  for (const CapNeed& need : report.needs) {
    json["caps"].push_back({{"fraction", need.fraction}, {"cap_bytes", nullptr}, {"reached", need.reached}});
    if (need.cap_bytes) json["caps"].back()["cap_bytes"] = *need.cap_bytes;
  }
  return json.dump(2);
}

Status run(const Arguments& arguments) {
  ZC_ASSIGN(const CapsReport report, measure_caps(arguments));
  if (!arguments.json.replaces_text()) print_table(report);
  return write_json(arguments.json, to_json(report));
}

}  // namespace

void add_caps(CLI::App& app, const SetCommand& set) {
  const auto a = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("caps", "Measure which memory cap a path needs for which level of quality");
  add_json_option(*command, a->json, add_world_option(*command, a->world));
  command
      ->add_option("--path", a->paths,
                   "Camera path (CSV) or still views (shots.json) [a flight over the world]; several: so many cameras")
      ->expected(1)
      ->take_all();
  command->add_option("--frames", a->frames, "Path samples A (inclusive) to B (exclusive): A:B, A:B:STEP or all");
  command
      ->add_option("--fractions", a->fractions,
                   "Shares of frames in which all that the tolerance asks for is there; separated by commas")
      ->delimiter(',')
      ->check(CLI::Range(0.0, 1.0))
      ->option_text("F,... [0.5,0.75,0.9,0.99,1]");
  command->add_option("--tolerance", a->tolerance, "As of the replay that the cap is for")
      ->capture_default_str()
      ->check(CLI::Range(1e-6, 1.0));
  command->add_option("--look-ahead", a->look_ahead_s, "As of that replay, in seconds")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 60.0));
  add_choice_option<Prediction>(*command, "--prediction", a->prediction,
                                {{"path", Prediction::kPath}, {"velocity", Prediction::kVelocity}}, "As of that replay",
                                "path");
  command->add_option("--threads", a->threads, "Streaming threads (0: all cores)")
      ->capture_default_str()
      ->check(CLI::Range(0U, 256U));
  command->callback([=] { set([=] { return run(*a); }); });
}

}  // namespace zc
