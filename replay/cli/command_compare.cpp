// SPDX-License-Identifier: Apache-2.0
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <iostream>
#include <memory>
#include <optional>
#include <thread>

#include "base/file.h"
#include "replay/cli/commands.h"
#include "replay/cli/json_option.h"
#include "replay/cli/progress.h"
#include "replay/cli/world_option.h"
#include "replay/compare/compare.h"
#include "replay/session/units.h"

namespace zc {
namespace {

constexpr std::uint64_t kReportLimitBytes = std::uint64_t{1} << 30U;

struct Arguments {
  WorldOption world;
  JsonOption json;
  std::string path, out, device, frames, size = "1280x720", budget = "256MiB";
  std::optional<std::string> sun;
  std::vector<double> tolerances = {0.002};
  unsigned threads = 0;
};

Result<CompareOptions> to_options(const Arguments& a) {
  CompareOptions options;
  options.world = a.world.place;
  ZC_ASSIGN(options.source, parse_source_options(a.world));
  options.out = a.out;
  options.device = a.device;
  if (!a.frames.empty()) {
    ZC_ASSIGN(options.frames, parse_frames(a.frames));
  }
  if (a.sun) {
    ZC_ASSIGN(options.sun, parse_sun(*a.sun));
  }
  ZC_ASSIGN(const PictureSize size, parse_size(a.size));
  options.renderer.width = size.width;
  options.renderer.height = size.height;
  ZC_ASSIGN(options.budget_bytes, parse_bytes(a.budget));
  options.threads = a.threads != 0 ? a.threads : std::max(1U, std::thread::hardware_concurrency());
  for (const double tolerance : a.tolerances)
    if (!std::isfinite(tolerance)) return Error{ErrorCode::kArgument, "--tolerance needs finite numbers"};
  options.tolerances = a.tolerances;
  if (!a.path.empty()) {
    ZC_ASSIGN(options.path, read_camera_path(a.path));
  }
  return options;
}

void print_table(const CompareReport& report, const std::filesystem::path& out) {
  std::cout << report.frames.size() << " frames against the full detail, on " << report.device << '\n'
            << "level               triangles a frame   FLIP mean   worst frame\n";
  for (const ComparedLevel& level : report.levels)
    std::cout << std::left << std::setw(20) << level.name << std::right << std::setw(17)
              << level.triangles / report.frames.size() << std::fixed << std::setprecision(4) << std::setw(12)
              << level.mean_flip << std::setw(14) << *std::max_element(level.flip.begin(), level.flip.end()) << '\n';
  std::cout << (out / "contact_sheet.png").string() << '\n';
}

Status run(const Arguments& arguments) {
  ZC_ASSIGN(CompareOptions options, to_options(arguments));
  std::optional<Progress> progress(std::in_place);
  options.progress = [&](double fraction, std::string_view stage) { progress->update(fraction, stage); };
  ZC_ASSIGN(const CompareReport report, run_compare(options));
  progress.reset();
  if (report.blind_frames > 0)
    spdlog::warn("{} of {} frames do not look at the world; they count as equal", report.blind_frames,
                 report.frames.size());
  const char* limit = report.limited_by_device ? "what the device binds" : "--budget";
  if (!report.source_complete)
    spdlog::warn("{} is too small for all of the full detail: proxies stand in for it where it is far away", limit);
  for (const ComparedLevel& level : report.levels)
    if (level.incomplete)
      spdlog::warn("{} is too small for all of level {}: it is coarser where it is far away", limit, level.name);
  if (!arguments.json.replaces_text()) print_table(report, options.out);
  if (!arguments.json.asked) return {};
  ZC_ASSIGN(const std::vector<std::byte> json, read_file(options.out / "compare.json", kReportLimitBytes));
  return write_json(arguments.json, {reinterpret_cast<const char*>(json.data()), json.size()});
}

}  // namespace

void add_compare(CLI::App& app, const SetCommand& set) {
  const auto a = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("compare",
                                         "Draw a world's proxies, level by level, against its full detail: pictures, "
                                         "maps of the difference, a contact sheet");
  add_json_option(*command, a->json, add_world_option(*command, a->world));
  command->add_option("--path", a->path, "Camera path (CSV) or still views (shots.json) [a flight over the world]");
  command->add_option("-o,--output", a->out, "Folder for pictures, maps of FLIP, contact_sheet.png and compare.json")
      ->required();
  command->add_option("--frames", a->frames, "A:B, A:B:STEP or all [8, spread evenly over the path]");
  command
      ->add_option("--tolerance", a->tolerances,
                   "Beside the stored levels, what a replay pages at these tolerances; separated by commas")
      ->delimiter(',')
      ->check(CLI::Range(1e-6, 1.0))
      ->option_text("T,... [0.002]");
  command->add_option("--size", a->size, "Picture size")->capture_default_str();
  command->add_option("--sun", a->sun,
                      "Sun: azimuth (degrees clockwise from north), elevation [the world's, else 145,38]");
  command->add_option("--budget", a->budget, "Memory for the zones of each level")->capture_default_str();
  command->add_option("--device", a->device, "Part of the Vulkan device's name");
  command->add_option("--threads", a->threads, "Threads (0: all cores)")->check(CLI::Range(0U, 256U));
  command->callback([=] { set([=] { return run(*a); }); });
}

}  // namespace zc
