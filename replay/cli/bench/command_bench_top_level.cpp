// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>

#include "baker/bake.h"
#include "baker/generate/city.h"
#include "baker/import/import.h"
#include "replay/bench/top_level_bench.h"
#include "replay/cli/commands.h"
#include "replay/cli/json_option.h"
#include "replay/cli/progress.h"
#include "replay/cli/world_option.h"
#include "replay/files/temporary_folder.h"

namespace zc {
namespace {

struct Arguments {
  WorldOption world;
  JsonOption json;
  std::size_t zones = 500;
  bench::TopLevelBenchOptions options;
};

Result<std::vector<bench::RootPage>> generated_pages() {
  TemporaryFolder folder;
  ZC_TRY(folder.create());
  ZC_TRY(generate_city({}, folder.path()));
  const std::vector<std::filesystem::path> inputs = {folder.path() / "city.glb"};
  ZC_ASSIGN(Scene scene, import_inputs(inputs));
  Progress progress;
  BakeOptions options;
  options.progress = [&](double fraction, std::string_view stage) { progress.update(fraction, stage); };
  ZC_TRY(bake_world(std::move(scene), 0, options, folder.path() / "world"));
  return bench::load_root_pages(folder.path() / "world");
}

Status run(const Arguments& a) {
  ZC_ASSIGN(const SourceOptions options, parse_source_options(a.world));
  std::filesystem::path world = a.world.place;
  if (!world.has_filename()) world = world.parent_path();
  ZC_ASSIGN(const auto pages, a.world.place.empty() ? generated_pages() : bench::load_root_pages(world, options));
  ZC_ASSIGN(const bench::TopLevelReport report,
            bench::run_top_level_bench(a.world.place.empty() ? "city" : world.filename().string(),
                                       bench::repeat_root_pages(pages, a.zones), a.options));
  if (!a.json.replaces_text()) std::cout << bench::top_level_table(report);
  return write_json(a.json, bench::top_level_json(report).dump(2));
}

}  // namespace

void add_bench_top_level(CLI::App& app, const SetCommand& set) {
  const auto a = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "top-level", "Rebuild the top level over many zones, as every change of residency does, and measure it");
  add_world_option(*command, a->world, "without it: the generated city");
  command->add_option("--zones", a->zones, "Zones; those of a smaller world are repeated side by side")
      ->capture_default_str()
      ->check(CLI::Range(1U, 20000U));
  command->add_option("--repeat", a->options.repeat, "Timed runs")
      ->capture_default_str()
      ->check(CLI::Range(1U, 100000U));
  command->add_option("--device", a->options.device, "Part of the Vulkan device's name");
  add_json_option(*command, a->json);
  command->callback([=] { set([=] { return run(*a); }); });
}

}  // namespace zc
