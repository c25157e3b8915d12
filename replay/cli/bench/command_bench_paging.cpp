// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>

#include "base/file.h"
#include "replay/bench/paging_bench.h"
#include "replay/cli/commands.h"
#include "replay/cli/json_option.h"
#include "replay/cli/world_option.h"
#include "replay/files/temporary_folder.h"
#include "replay/session/units.h"

namespace zc {
namespace {

struct Arguments {
  WorldOption world;
  JsonOption json;
  std::string pool = "128MiB";
  std::vector<std::uint32_t> nodes = {10000, 100000, 1000000};
  bench::PagingBenchOptions options;
};

Status run(const Arguments& a) {
  bench::PagingBenchOptions options = a.options;
  ZC_ASSIGN(options.pool_bytes, parse_bytes(a.pool));
  ZC_ASSIGN(options.source, parse_source_options(a.world));
  std::vector<bench::PagingReport> reports;
  if (!a.world.place.empty()) {
    ZC_ASSIGN(reports.emplace_back(), bench::run_paging_bench("world", a.world.place, options));
  }
  for (const std::uint32_t nodes : a.nodes) {
    if (!a.world.place.empty()) break;
    TemporaryFolder folder;
    ZC_TRY(folder.create());
    ZC_TRY(write_file(folder.path() / kWorldIndexName, encode_world_index(bench::make_synthetic_index(nodes))));
    ZC_ASSIGN(reports.emplace_back(),
              bench::run_paging_bench("synthetic_" + std::to_string(nodes), folder.path(), options));
  }
  if (!a.json.replaces_text()) std::cout << bench::paging_table(reports);
  return write_json(a.json, bench::paging_json(reports).dump(2));
}

}  // namespace

void add_bench_paging(CLI::App& app, const SetCommand& set) {
  const auto a = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "paging", "What a world's size costs: opening its index, and choosing what should be resident frame by frame");
  add_world_option(*command, a->world, "without it: synthetic indices");
  command->add_option("--nodes", a->nodes, "Nodes of the synthetic indices; separated by commas")
      ->delimiter(',')
      ->capture_default_str()
      ->check(CLI::Range(1U, 4000000U));
  command->add_option("--pool", a->pool, "Page pool that the selection fills")->capture_default_str();
  command->add_option("--frames", a->options.frames, "Frames of the flight, 30 a second")
      ->capture_default_str()
      ->check(CLI::Range(1U, 100000U));
  command->add_option("--tolerance", a->options.tolerance, "As of replay")
      ->capture_default_str()
      ->check(CLI::Range(1e-6, 1.0));
  add_json_option(*command, a->json);
  command->callback([=] { set([=] { return run(*a); }); });
}

}  // namespace zc
