// SPDX-License-Identifier: Apache-2.0
// The table and the JSON of `zonecast bench trace`.
#include <algorithm>
#include <array>
#include <string_view>

#include "replay/bench/print_figures.h"
#include "replay/bench/trace_bench.h"

namespace zc::bench {
namespace {

constexpr std::array<std::string_view, 3> kYardsticks = {"ray_query", "thesis", "embree"};

double mrays_per_s(const TraceBenchReport& report, double ms) {
  return ms > 0 ? static_cast<double>(report.rays) / ms * 1e-3 : 0;
}

// Of the time that the device's memory alone would ask for: rays read, hits written and the scene read, each once.
// 0 where that is not known.
double bandwidth_share(const TraceBenchReport& report, const EngineRow& row) {
  if (!row.on_device || report.copy_gb_per_s <= 0 || row.median_ms <= 0) return 0;
  const double bytes = static_cast<double>(report.rays * (sizeof(BenchRay) + sizeof(BenchHit)) + row.figures.bytes);
  return bytes / (report.copy_gb_per_s * 1e6) / row.median_ms;
}

double bytes_per_triangle(const TraceBenchReport& report, const EngineRow& row) {
  return static_cast<double>(row.figures.bytes) / static_cast<double>(report.triangles);
}

}  // namespace

std::string trace_table(const TraceBenchReport& report) {
  std::string text = report.scene + ": " + std::to_string(report.rays) +
                     (report.any_hit ? " rays for any hit, " : " rays for the closest hit, ") +
                     std::to_string(report.triangles) + " triangles in " + std::to_string(report.zones) + " zones";
  if (!report.device.empty()) {
    text += "; " + report.device + ", " + report.driver;
    text += format(", memory copies %.0f GB/s", report.copy_gb_per_s);
  }
  text += "\n" + format("%-12s %-22s %9s %9s %9s %8s %7s %10s", "case", "engine", "Mrays/s", "best", "build ms",
                        "B/tri", "memory", "mismatches");
  for (const std::string_view yardstick : kYardsticks) text += format(" %11s", ("x " + std::string(yardstick)).c_str());
  text += '\n';
  for (const EngineRow& row : report.rows) {
    text += format("%-12s %-22s %9.3f %9.3f %9.1f %8.1f %7s %10llu", report.scene.substr(0, 12).c_str(),
                   row.engine.c_str(), mrays_per_s(report, row.median_ms), mrays_per_s(report, row.best_ms),
                   row.figures.build_ms, bytes_per_triangle(report, row),
                   row.on_device ? format("%.1f %%", 100 * bandwidth_share(report, row)).c_str() : "-",
                   static_cast<unsigned long long>(row.comparison.mismatches));
    for (const std::string_view yardstick : kYardsticks) {
      const auto other = std::ranges::find(report.rows, yardstick, &EngineRow::engine);
      text += other == report.rows.end() || row.median_ms <= 0 ? format(" %11s", "-")
                                                               : format(" %11.2f", other->median_ms / row.median_ms);
    }
    text += '\n';
  }
  for (const std::string& cause : report.left_out) text += "left out: " + cause + '\n';
  return text;
}

nlohmann::ordered_json trace_json(const TraceBenchReport& report) {
  nlohmann::ordered_json json = {{"driver", report.driver},
                                 {"device", report.device},
                                 {"rays", report.rays},
                                 {"triangles", report.triangles},
                                 {"copy_gb_per_s", report.copy_gb_per_s},
                                 {"zones", report.zones},
                                 {"any_hit", report.any_hit},
                                 {"left_out", report.left_out}};
  json["rows"] = nlohmann::ordered_json::array();
  for (const EngineRow& row : report.rows) {
    json["rows"].push_back({{"case", report.scene},
                            {"engine", row.engine},
                            {"mrays_per_s", mrays_per_s(report, row.median_ms)},
                            {"best_mrays_per_s", mrays_per_s(report, row.best_ms)},
                            {"build_ms", row.figures.build_ms},
                            {"bytes_per_triangle", bytes_per_triangle(report, row)},
                            {"bandwidth_share", bandwidth_share(report, row)},
                            {"mismatches", row.comparison.mismatches},
                            {"same", row.comparison.same},
                            {"tied", row.comparison.tied},
                            {"missed_by_both", row.comparison.missed_by_both}});
  }
  return json;
}

}  // namespace zc::bench
