// SPDX-License-Identifier: Apache-2.0
#include <spdlog/spdlog.h>
#include <charconv>
#include <cmath>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <memory>
#include <optional>

#include "baker/bake.h"
#include "baker/import/identify_input.h"
#include "baker/import/import.h"
#include "baker/import/stray_objects.h"
#include "baker/scene/bake_cache.h"
#include "base/file.h"
#include "base/text.h"
#include "replay/cli/bvh_option.h"
#include "replay/cli/commands.h"
#include "replay/cli/json_option.h"
#include "replay/cli/placement_option.h"
#include "replay/cli/progress.h"
#include "replay/session/units.h"
#include "streamer/source/source.h"

namespace zc {
namespace {

constexpr double kHighestPlane_m = 1e5;
constexpr std::uint64_t kRulesLimitBytes = std::uint64_t{1} << 24U;
constexpr std::uint64_t kReportLimitBytes = std::uint64_t{1} << 30U;

struct Arguments {
  std::vector<std::string> inputs;
  std::string out;
  JsonOption json;
  ProgressOption progress;
  std::optional<std::string> sun;
  ImportOptions import;
  PlacementOption placement;
  std::string materials;
  bool wet = false, strict = false;
  std::string ground_plane;
  BakeOptions options;
};

// A city where FILE of --json should stand is there by mistake: `bake --json a.json b.json`.
Status check_json_file(const JsonOption& json) {
  std::ifstream file(json.file);
  std::string begin(12, '\0');
  if (json.file.empty() || !file.read(begin.data(), 12) || begin == "{\n  \"bake_s\"") return {};
  return Error{ErrorCode::kArgument, "is there and not a bake's report; --json does not replace it", json.file};
}

Status read_material_rules(const Arguments& arguments, MaterialRules& rules) {
  if (!arguments.materials.empty()) {
    ZC_ASSIGN(const std::vector<std::byte> bytes, read_file(arguments.materials, kRulesLimitBytes));
    ZC_ASSIGN(rules,
              MaterialRules::parse({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, arguments.materials));
  }
  if (arguments.wet) rules.wet_ground();
  return {};
}

Status read_ground_plane(const std::string& text, ImportOptions& import) {
  import.ground_plane = !text.empty();
  if (text.empty() || text == "lowest") return {};
  double z_m = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), z_m);
  if (failure != std::errc() || end != text.data() + text.size() || !(std::abs(z_m) <= kHighestPlane_m))
    return Error{ErrorCode::kArgument, "--ground-plane is 'lowest' or a height in metres, not '" + text + "'"};
  import.ground_plane_z_m = z_m;
  return {};
}

void print_summary(const Arguments& arguments, const BakeReport& report, bool reused) {
  std::size_t zones = 0;
  for (const NodeRecord& node : report.index.nodes) zones += node.is_detail() ? 1 : 0;
  const auto counted = [](std::uint64_t count, const char* what) {
    return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
  };
  std::cout << arguments.out << ": " << counted(report.index.header.source_triangles, "triangle") << " in "
            << counted(zones, "zone") << ", " << counted(report.index.nodes.size(), "node");
  if (reused) std::cout << " (" << report.proxies_reused << " proxies as before)";
  std::cout << ", " << std::fixed << std::setprecision(1) << report.seconds.total << " s, peak memory "
            << format_bytes(report.peak_rss_bytes) << '\n'
            << std::setprecision(report.reflecting_share > 0 && report.reflecting_share < 0.1 ? 2 : 0)
            << 100 * report.reflecting_share << " % of the surface reflects"
            << (report.reflecting_share > 0 ? "" : ": --wet or --materials makes a world that does") << '\n';
}

Result<BakeOrigin> origin_of(const Arguments& arguments) {
  BakeOrigin origin{.version = ZONECAST_VERSION,
                    .ground_plane = arguments.ground_plane,
                    .wet = arguments.wet,
                    .skip_missing = arguments.import.skip_missing,
                    .strict = arguments.strict,
                    .scale = arguments.placement.scales,
                    .up = arguments.placement.ups,
                    .offset = arguments.placement.offsets,
                    .crs = arguments.placement.systems};
  for (const std::string& input : arguments.inputs) {
    ZC_ASSIGN(origin.inputs.emplace_back(), identify_input(input));
  }
  if (!arguments.materials.empty()) {
    ZC_ASSIGN(origin.materials, identify_input(arguments.materials));
  }
  return origin;
}

// An input that the bake would replace, or empty as what an earlier one left.
Status check_apart(const std::filesystem::path& input, const std::filesystem::path& out) {
  std::error_code code;
  const std::filesystem::path target = std::filesystem::absolute(out, code).lexically_normal();
  const std::filesystem::path world = target.has_filename() ? target : target.parent_path();
  const std::filesystem::path beside = world.parent_path() / ("." + world.filename().string() + ".baking");
  std::filesystem::path at = std::filesystem::weakly_canonical(input, code);
  if (code || is_url(input.native())) return {};  // who opens it says why
  for (; at.has_relative_path(); at = at.parent_path())
    for (const std::filesystem::path& taken : {world, beside})
      if (std::filesystem::equivalent(at, taken, code))
        return Error{ErrorCode::kArgument,
                     "lies in '" + out.string() + "', which this bake replaces; name another output", input.string()};
  return {};
}

// What the import left out or replaced: all kinds that fit a line.
Status check_whole(const Scene& scene, const std::string& input) {
  constexpr std::size_t kKinds = 5;
  std::string named;
  std::size_t kinds = 0;
  for (const ImportCount& note : scene.notes) {
    if (!note.is_loss || kinds++ >= kKinds) continue;
    named += (named.empty() ? "" : "; ") + note.what + ": " + std::to_string(note.count);
    if (!note.names.empty()) named += " (first: " + printable(note.names.front(), 80) + ")";
  }
  if (kinds == 0) return {};
  if (kinds > kKinds) named += "; and " + std::to_string(kinds - kKinds) + " more kinds";
  return Error{ErrorCode::kUnsupported,
               "not all of it can be baked as it is: " + named + "; mend that, or bake without --strict", input};
}

Status run(const Arguments& arguments) {
  const auto is_empty = [](const std::string& name) { return name.empty(); };
  if (is_empty(arguments.out) || std::ranges::any_of(arguments.inputs, is_empty))
    return Error{ErrorCode::kArgument, "an input or the output has an empty name"};
  ZC_TRY(check_json_file(arguments.json));
  for (const std::string& input : arguments.inputs) ZC_TRY(check_apart(input, arguments.out));
  if (!arguments.materials.empty()) ZC_TRY(check_apart(arguments.materials, arguments.out));
  std::error_code failure;
  const bool had_cache = std::filesystem::exists(std::filesystem::path(arguments.out) / kBakeCacheName, failure);
  ZC_ASSIGN(WorldWriter writer, WorldWriter::open(arguments.out));
  ImportOptions import = arguments.import;
  ZC_ASSIGN(import.placements, placements_of(arguments.placement, arguments.inputs.size()));
  ZC_TRY(read_material_rules(arguments, import.materials));
  ZC_TRY(read_ground_plane(arguments.ground_plane, import));
  std::optional<Progress> progress(std::in_place, arguments.progress);
  BakeOptions options = arguments.options;
  if (arguments.sun) {
    ZC_ASSIGN(options.sun, parse_sun(*arguments.sun));
    if (options.sun->elevation_deg < 0)
      return Error{ErrorCode::kArgument, "a sun below the horizon lights nothing: '" + *arguments.sun + "'"};
    if (!options.light) return Error{ErrorCode::kArgument, "--sun needs light"};
  }
  options.progress = [&](double fraction, std::string_view stage) { progress->update(fraction, stage); };
  progress->update(0, "import");
  const auto started = std::chrono::steady_clock::now();
  const std::vector<std::filesystem::path> inputs(arguments.inputs.begin(), arguments.inputs.end());
  ZC_ASSIGN(Scene scene, import_inputs(inputs, import));
  const std::chrono::duration<double> import_s = std::chrono::steady_clock::now() - started;
  for (const std::string& line : describe_stray_objects(scene)) spdlog::warn("{}", line);
  if (arguments.strict) ZC_TRY(check_whole(scene, arguments.inputs.front()));
  ZC_ASSIGN(options.origin, origin_of(arguments));
  Result<BakeReport> baked = bake_world(std::move(scene), import_s.count(), options, std::move(writer));
  if (!baked) {
    Error error = std::move(baked).error();  // of the scene as a whole: its first file stands for it
    if (error.path.empty() && error.code != ErrorCode::kArgument) error.path = arguments.inputs.front();
    return error;
  }
  const BakeReport& report = *baked;
  progress->finish();
  progress.reset();  // its bar goes before the summary comes

  for (const auto* notes : {&report.notes, &report.repair.counts})
    for (const ImportCount& note : *notes) {
      const std::string first = note.names.empty() ? "" : " (first: " + printable(note.names.front(), 160) + ")";
      spdlog::info("{}: {}{}", note.what, note.count, first);
    }
  if (report.interior_faces > 0)
    spdlog::info("faces that can be seen from nowhere outside, left out: {}", report.interior_faces);
  if (!arguments.json.replaces_text() && !arguments.progress.quiet)
    print_summary(arguments, report, had_cache && options.reuse);
  if (!arguments.json.asked) return {};
  ZC_ASSIGN(const std::vector<std::byte> json,
            read_file(std::filesystem::path(arguments.out) / kBakeReportName, kReportLimitBytes));
  return write_json(arguments.json, {reinterpret_cast<const char*>(json.data()), json.size()});
}

}  // namespace

void add_bake(CLI::App& app, const SetCommand& set) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("bake", "Bake city models into a world of zones");
  command
      ->add_option(
          "inputs", arguments->inputs,
          "glTF, GLB, CityJSON, CityJSONSeq, CityGML, OBJ, PLY, 3D Tiles (also on the web), each also packed (.gz, "
          ".zip); folders of them; -: CityJSONSeq from stdin")
      ->required();
  add_json_option(*command, arguments->json, command->get_option("inputs"));
  command->add_option("-o,--output", arguments->out, "World folder to write; an old world there is replaced")
      ->required();
  command
      ->add_option("--error", arguments->options.error_m, "Bound on the surface error of the finest proxies, in metres")
      ->capture_default_str()
      ->check(CLI::Range(0.001, 100.0));
  command->add_flag("!--from-scratch", arguments->options.reuse,
                    "Reuse nothing of the old world, and store nothing (bake.cache) for the next bake");
  add_bvh_option(*command, arguments->options.bvh.method, "How BVHs are built; auto: the cheapest on simulated rays");
  command->add_option("--leaf-triangles", arguments->options.leaf_triangles, "Triangles at which a zone is split")
      ->capture_default_str()
      ->check(CLI::Range(64U, 65535U));
  command
      ->add_option("--atlas", arguments->options.atlas_size,
                   "Largest texture atlas of a zone, in texels a side, halved level by level; 0: mean colours only")
      ->capture_default_str()
      ->check(CLI::IsMember({0, 32, 64, 128, 256, 512, 1024}));
  command->add_flag("!--no-light", arguments->options.light,
                    "Bake no light: the sky reaches every surface, and no surface lights another");
  command->add_option(
      "--sun", arguments->sun,
      "Sun, azimuth (degrees clockwise from north) and elevation, as in 145,38: what it reaches is stored too, "
      "so that a replay under the same sun needs no shadow rays");
  command->add_flag("--exterior", arguments->options.exterior,
                    "Leave out faces that cannot be seen from outside: rooms without an opening, what is in them, and "
                    "walls between buildings that touch");
  add_placement_options(*command, arguments->placement);
  command->add_flag("--skip-missing", arguments->import.skip_missing,
                    "Bake a tileset without the tiles that are not there: they are counted and the first ones named");
  command->add_flag("--strict", arguments->strict,
                    "Exit code 1, and no world, when anything of the inputs is left out or replaced");
  command->add_option("--materials", arguments->materials,
                      "JSON file of what surfaces are made of, by surface type, object type, name or material");
  command->add_flag("--wet", arguments->wet, "Ground and roads are dark and smooth, as after rain");
  command->add_option("--ground-plane", arguments->ground_plane,
                      "Put a plane under everything: lowest (as its lowest point) or a height in metres");
  command->add_option("--threads", arguments->options.threads, "Threads (0: all cores)")
      ->capture_default_str()
      ->check(CLI::Range(0U, 256U));
  add_progress_options(*command, arguments->progress);
  command->callback([=] { set([=] { return run(*arguments); }); });
}

}  // namespace zc
