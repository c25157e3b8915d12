// SPDX-License-Identifier: Apache-2.0
#include <spdlog/spdlog.h>

#include <algorithm>
#include <iomanip>
#include <iostream>
#include <memory>

#include "replay/cli/commands.h"
#include "replay/cli/json_option.h"
#include "replay/cli/progress.h"
#include "replay/cli/world_option.h"
#include "replay/paths/world_tour.h"
#include "replay/report/thesis_table.h"
#include "replay/report/world_report.h"
#include "replay/session/units.h"
#include "streamer/open_source.h"
#include "streamer/source/index_file.h"

namespace zc {
namespace {

constexpr std::size_t kFailuresShown = 20;

struct Arguments {
  WorldOption world;
  JsonOption json;
  bool verify = false;
};

void print_table(const nlohmann::ordered_json& json, const WorldIndex& index) {
  std::cout << json["zones"] << " zones, " << json["nodes"] << " nodes, " << json["source_triangles"]
            << " source triangles\n"
            << "bounds: " << describe_bounds(index) << "\n"
            << "CRS: " << (index.crs.empty() ? "none was named" : json["crs"].dump()) << "\n"
            << "resident when all is loaded: " << format_bytes(json["decoded_bytes"]) << ", smallest cap "
            << format_bytes(json["smallest_cap_bytes"]) << "\n"
            << "on disk: glb " << format_bytes(json["disk_bytes"]["glb"]) << ", zbvh "
            << format_bytes(json["disk_bytes"]["zbvh"]) << ", index " << format_bytes(json["disk_bytes"]["index"])
            << "\n\n depth   nodes  triangles   B/triangle  error max m  error mean m  appearance max m\n";
  for (const auto& level : json["levels"]) {
    std::cout << std::setw(6) << (level["detail"] ? std::string("detail") : level["depth"].dump()) << std::setw(8)
              << level["nodes"].dump() << std::setw(11) << level["triangles"].dump() << std::fixed
              << std::setprecision(1) << std::setw(13) << level["bytes_per_triangle"].get<double>()
              << std::setprecision(3) << std::setw(13) << level["error_m_max"].get<double>() << std::setw(14)
              << level["error_m_mean"].get<double>() << std::setw(18) << level["appearance_error_m_max"].get<double>()
              << '\n';
  }
  std::cout << "\nbytes a proxy triangle, resident:" << std::setprecision(2);
  for (const auto& [part, bytes] : json["resident_bytes_per_triangle"].items())
    std::cout << ' ' << part << ' ' << bytes.get<double>() << (part == "total" ? "\n" : ",");
  std::cout << "bytes a proxy triangle, on disk:";
  for (const auto& [part, bytes] : json["disk_bytes_per_triangle"].items())
    std::cout << ' ' << part << ' ' << bytes.get<double>() << (part == "total" ? "\n" : ",");
  for (const auto& left : json["left_out"]) {
    const std::string what = left["what"].dump();  // control characters escaped
    std::cout << "left out: " << left["count"] << ' ' << what.substr(1, what.size() - 2) << ": "
              << format_bytes(left["page_bytes"]) << " of pages";
    if (left.contains("disk_bytes")) std::cout << ", " << format_bytes(left["disk_bytes"]) << " on disk";
    std::cout << '\n';
  }
  std::cout << '\n';
  print_thesis_table(std::cout, json["table_4_1"]);
}

Status run(const Arguments& arguments) {
  ZC_ASSIGN(const SourceOptions options, parse_source_options(arguments.world));
  ZC_ASSIGN(const auto source, open_source(arguments.world.place, options));
  ZC_ASSIGN(const WorldIndex index, read_world_index(*source, arguments.world.place));
  nlohmann::ordered_json json = describe_world(*source, index);
  std::vector<Error> failures;
  if (arguments.verify) {
    Progress progress;
    failures = verify_world(*source, index,
                            [&](double fraction, std::string_view stage) { progress.update(fraction, stage); });
    json["verified"] = {{"nodes", index.nodes.size()}, {"failures", failures.size()}};
  }
  if (!arguments.json.replaces_text()) {
    print_table(json, index);
    if (arguments.verify)
      std::cout << "\nverified " << index.nodes.size() << " nodes, " << json["verified"]["failures"] << " failures\n";
  }
  ZC_TRY(write_json(arguments.json, json.dump(2)));
  if (failures.empty()) return {};
  // A line each; the first one is this command's own.
  for (std::size_t i = 1; i < std::min(failures.size(), kFailuresShown); ++i)
    spdlog::error("{}", failures[i].describe());
  if (failures.size() > kFailuresShown) spdlog::error("{} more nodes failed", failures.size() - kFailuresShown);
  return failures.front();
}

}  // namespace

void add_inspect(CLI::App& app, const SetCommand& set) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("inspect", "Show what a world contains: bounds, zones, levels, bytes, errors");
  add_json_option(*command, arguments->json, add_world_option(*command, arguments->world));
  command->add_flag("--verify", arguments->verify, "Read, decode and check every page; exit 1 when one fails");
  command->callback([=] { set([=] { return run(*arguments); }); });
}

}  // namespace zc
