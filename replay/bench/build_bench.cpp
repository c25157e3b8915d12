// SPDX-License-Identifier: Apache-2.0
#include "replay/bench/build_bench.h"

#include <algorithm>
#include <ctime>
#include <optional>

#include "replay/bench/engines/engine_names.h"
#include "replay/bench/engines/parallel_chunks.h"
#include "replay/bench/engines/stopwatch.h"
#include "replay/bench/print_figures.h"

namespace zc::bench {
namespace {

struct Built {
  double ms = 0;
  double cpu_ms = 0;
  std::vector<TreeProbe> appearances;  // by zone
};

Result<Built> build_all(const TreeBuilder& builder, std::size_t zones, unsigned threads) {
  Built built;
  built.appearances.resize(zones);
  std::vector<Status> results(zones);
  const std::clock_t cpu = std::clock();
  const Stopwatch watch;
  parallel_chunks<1>(zones, threads, [&](std::size_t zone, std::size_t /*end*/) {
    Result<TreeProbe> appearance = builder.build(zone);
    if (appearance) {
      built.appearances[zone] = *std::move(appearance);
    } else {
      results[zone] = std::move(appearance).error();
    }
  });
  built.ms = watch.ms();
  built.cpu_ms = 1e3 * static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
  for (Status& result : results) ZC_TRY(std::move(result));
  return built;
}

Result<TreeFigures> look_at_all(const Built& built, unsigned threads) {
  std::vector<std::optional<Result<TreeFigures>>> figures(built.appearances.size());
  parallel_chunks<1>(figures.size(), threads,
                     [&](std::size_t zone, std::size_t /*end*/) { figures[zone] = built.appearances[zone](); });
  TreeFigures sum;
  for (const auto& result : figures) {
    if (!*result) return result->error();
    const TreeFigures& f = **result;
    sum.nodes += f.nodes;
    sum.references += f.references;
    sum.depth = std::max(sum.depth, f.depth);
    sum.page_bytes += f.page_bytes;
    sum.sah_cost += f.sah_cost;
    sum.ray_cost += f.ray_cost;
    sum.mismatches += f.mismatches;
  }
  return sum;
}

// Rates and means of a row.
struct Rates {
  double mtri_per_s;
  double mtri_per_s_core;
  double bytes_per_triangle;
  double references_per_triangle;
  double sah_cost;
  double ray_cost;
};

Rates rates_of(const BuildBenchReport& report, const BuildRow& row) {
  const auto triangles = static_cast<double>(report.triangles);
  const auto zones = static_cast<double>(report.zones);
  const double mtri_per_s = row.median_ms > 0 ? triangles / row.median_ms * 1e-3 : 0;
  return {mtri_per_s,
          row.median_cpu_ms > 0 ? triangles / row.median_cpu_ms * 1e-3 : 0,
          static_cast<double>(row.sum.page_bytes) / triangles,
          static_cast<double>(row.sum.references) / triangles,
          row.sum.sah_cost / zones,
          row.sum.ray_cost / zones};
}

}  // namespace

Status check_builders(const std::vector<TreeBuilder>& builders, const std::vector<std::string>& engines) {
  ZC_TRY(check_names(builders, engines));
  if (engines.empty()) return {};
  for (const TreeBuilder* builder : choose_by_name(builders, engines))
    if (!builder->build) return Error{ErrorCode::kDevice, builder->name + ": " + builder->missing};
  return {};
}

Result<BuildBenchReport> run_build_bench(std::string scene, std::uint64_t triangles, std::size_t zones,
                                         const std::vector<TreeBuilder>& builders, const BuildBenchOptions& options) {
  BuildBenchReport report;
  report.scene = std::move(scene);
  report.triangles = triangles;
  report.zones = zones;
  report.threads = options.threads;
  ZC_TRY(check_builders(builders, options.engines));
  std::vector<const TreeBuilder*> wanted = choose_by_name(builders, options.engines);
  std::erase_if(wanted, [&](const TreeBuilder* builder) {
    if (!builder->build) report.left_out.push_back(builder->name + ": " + builder->missing);
    return !builder->build;
  });
  std::vector<const TreeBuilder*> chosen;
  double done = 0;
  const auto show = [&](std::string_view stage) {
    if (options.progress) options.progress(done / static_cast<double>(wanted.size() * (options.repeat + 1)), stage);
    ++done;
  };
  for (const TreeBuilder* builder : wanted) {  // this build warms up and is not timed
    show(builder->name);
    ZC_ASSIGN(const Built built, build_all(*builder, zones, options.threads));
    Result<TreeFigures> sum = look_at_all(built, options.threads);
    if (!sum) {
      const std::string cause = builder->name + ": " + sum.error().message;
      if (!options.engines.empty()) return Error{sum.error().code, cause};
      report.left_out.push_back(cause);
      continue;
    }
    chosen.push_back(builder);
    report.rows.push_back({builder->name, 0, 0, 0, *sum});
  }
  // In turn, so that whatever else the machine does hits all alike.
  std::vector<std::vector<double>> times(chosen.size());
  std::vector<std::vector<double>> cpu_times(chosen.size());
  for (unsigned round = 0; round < options.repeat; ++round) {
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      show(chosen[i]->name);
      ZC_ASSIGN(const Built built, build_all(*chosen[i], zones, options.threads));
      times[i].push_back(built.ms);
      cpu_times[i].push_back(built.cpu_ms);
    }
  }
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    report.rows[i].best_ms = std::ranges::min(times[i]);
    report.rows[i].median_ms = median(std::move(times[i]));
    report.rows[i].median_cpu_ms = median(std::move(cpu_times[i]));
  }
  return report;
}

std::string build_table(const BuildBenchReport& report) {
  std::string text = report.scene + ": " + std::to_string(report.triangles) + " triangles in " +
                     std::to_string(report.zones) + " zones, " + std::to_string(report.threads) + " threads\n" +
                     format("%-12s %-24s %9s %8s %9s %8s %8s %6s %9s %9s %10s\n", "case", "engine", "build ms",
                            "Mtri/s", "/s/core", "B/tri", "ref/tri", "depth", "SAH cost", "ray cost", "mismatches");
  for (const BuildRow& row : report.rows) {
    const Rates rates = rates_of(report, row);
    text += format("%-12s %-24s %9.1f %8.2f %9.2f %8.1f %8.3f %6u %9.2f %9.2f %10llu\n",
                   report.scene.substr(0, 12).c_str(), row.engine.c_str(), row.median_ms, rates.mtri_per_s,
                   rates.mtri_per_s_core, rates.bytes_per_triangle, rates.references_per_triangle, row.sum.depth,
                   rates.sah_cost, rates.ray_cost, static_cast<unsigned long long>(row.sum.mismatches));
  }
  for (const std::string& cause : report.left_out) text += "left out: " + cause + '\n';
  return text;
}

nlohmann::ordered_json build_json(const BuildBenchReport& report) {
  nlohmann::ordered_json json = {{"triangles", report.triangles},
                                 {"zones", report.zones},
                                 {"threads", report.threads},
                                 {"left_out", report.left_out}};
  json["rows"] = nlohmann::ordered_json::array();
  for (const BuildRow& row : report.rows) {
    const Rates rates = rates_of(report, row);
    json["rows"].push_back({{"case", report.scene},
                            {"engine", row.engine},
                            {"build_ms", row.median_ms},
                            {"best_build_ms", row.best_ms},
                            {"cpu_ms", row.median_cpu_ms},
                            {"mtri_per_s", rates.mtri_per_s},
                            {"mtri_per_s_core", rates.mtri_per_s_core},
                            {"bytes_per_triangle", rates.bytes_per_triangle},
                            {"references_per_triangle", rates.references_per_triangle},
                            {"nodes", row.sum.nodes},
                            {"depth", row.sum.depth},
                            {"sah_cost", rates.sah_cost},
                            {"ray_cost", rates.ray_cost},
                            {"mismatches", row.sum.mismatches}});
  }
  return json;
}

}  // namespace zc::bench
