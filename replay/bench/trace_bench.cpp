// SPDX-License-Identifier: Apache-2.0
#include "replay/bench/trace_bench.h"

#include <algorithm>
#include <memory>
#include <optional>

#include "replay/bench/clock_warmer.h"
#include "replay/bench/engines/engine_names.h"
#include "replay/bench/engines/engines.h"
#include "replay/bench/engines/gpu_engine.h"
#include "replay/bench/print_figures.h"

namespace zc::bench {
Status check_engine_names(std::span<const std::string> names) { return check_names(all_engines(), names); }

Result<TraceBenchReport> run_trace_bench(const BenchScene& scene, const Oracle& oracle, std::span<const BenchRay> rays,
                                         const TraceBenchOptions& options) {
  TraceBenchReport report;
  report.scene = scene.name;
  report.any_hit = options.any_hit;
  report.rays = rays.size();
  report.triangles = scene.triangles.size();
  report.zones = scene.zones.size();

  const std::vector<const EngineEntry*> chosen = choose_by_name(all_engines(), options.engines);
  const bool by_name = !options.engines.empty();
  EngineContext context{nullptr, &options.page_builder, options.threads, options.any_hit};
  std::unique_ptr<Device> device;
  ClockWarmer warmer;
  std::string no_device;
  if (std::ranges::any_of(chosen, &EngineEntry::needs_device)) {
    DeviceOptions wanted;
    wanted.name = options.device;
    wanted.ray_query = true;
    wanted.subgroup_sizes = true;
    Result<std::unique_ptr<Device>> created = Device::create(wanted);
    if (!created && (by_name || !options.device.empty())) return std::move(created).error();
    if (created) {
      device = *std::move(created);
      context.device = device.get();
      report.device = device->name();
      report.driver = device->driver();
      ZC_ASSIGN(warmer, ClockWarmer::create(*device));
      ZC_TRY(warmer.warm());
      ZC_ASSIGN(report.copy_gb_per_s, copy_gb_per_s(*device));
    } else {
      no_device = created.error().describe();
    }
  }

  std::vector<std::unique_ptr<TraceEngine>> engines;
  std::vector<bool> on_device;  // by engine
  for (const EngineEntry* entry : chosen) {
    const std::string missing =
        entry->needs_device && device == nullptr ? no_device : std::string(entry->missing(context));
    if (!missing.empty()) {
      const std::string cause = std::string(entry->name) + ": " + missing;
      if (by_name) return Error{ErrorCode::kDevice, cause};
      report.left_out.push_back(cause);
      continue;
    }
    engines.push_back(entry->make(context, entry->name));
    on_device.push_back(entry->needs_device);
  }
  double done = 0;
  const auto show = [&](std::string_view stage) {
    const auto all = static_cast<double>(engines.size() * (options.repeat + 1) + 1);
    if (options.progress) options.progress(done / all, stage);
    ++done;
  };
  show("oracle");
  // The first trace of each is held against the truth and warms up; it is not timed.
  const std::vector<OracleHit> expected = oracle.trace(rays, options.threads);
  std::vector<BenchHit> hits(rays.size());
  for (std::size_t i = 0; i < engines.size(); ++i) {
    std::unique_ptr<TraceEngine>& engine = engines[i];
    EngineRow row;
    row.engine = engine->name();
    row.on_device = on_device[i];
    show(row.engine);
    const auto named = [&](Error error) {
      error.message = row.engine + ": " + error.message;
      return error;
    };
    if (Status built = engine->build(scene); !built.ok()) return named(std::move(built).error());
    row.figures = engine->figures();
    std::ranges::fill(hits, BenchHit{0, kMiss - 1});  // a hit that an engine does not write is a wrong one
    if (Result<double> traced = engine->trace(rays, hits); !traced) {
      if (by_name || traced.error().code != ErrorCode::kUnsupported) return named(std::move(traced).error());
      report.left_out.push_back(row.engine + ": " + traced.error().message);  // the scene is too deep for it, say
      engine.reset();
      continue;
    }
    row.comparison = compare(oracle, rays, expected, hits, scene.triangles.size(), options.any_hit, options.threads);
    report.rows.push_back(std::move(row));
  }
  std::erase(engines, nullptr);
  // In turn, so that whatever else the machine does hits all alike.
  std::vector<std::vector<double>> times(engines.size());
  for (unsigned round = 0; round < options.repeat; ++round) {
    for (std::size_t i = 0; i < engines.size(); ++i) {
      show(report.rows[i].engine);
      if (report.rows[i].on_device) ZC_TRY(warmer.warm());
      ZC_ASSIGN(const double ms, engines[i]->trace(rays, hits));
      times[i].push_back(ms);
    }
  }
  for (std::size_t i = 0; i < engines.size(); ++i) {
    report.rows[i].best_ms = std::ranges::min(times[i]);
    report.rows[i].median_ms = median(times[i]);
  }
  return report;
}

}  // namespace zc::bench
