// SPDX-License-Identifier: Apache-2.0
// Runs engines over the same rays, in turn, holds their hits against the oracle and tabulates what they cost.
// Borrows what it is given. Threads: one at a time. Units: milliseconds, millions of rays a second.
// Fails when an engine that was asked for by name is not there, and when one fails; one that was not asked for by name
// and cannot run here is left out and named in the report.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "replay/bench/engines/trace_engine.h"
#include "replay/bench/engines/zonecast_engine.h"
#include "replay/bench/oracle.h"

namespace zc::bench {

struct TraceBenchOptions {
  std::vector<std::string> engines;  // empty: all that are there
  unsigned repeat = 5;
  unsigned threads = 2;
  bool any_hit = false;      // whether something is hit; else the closest hit
  PageBuilder page_builder;  // without it our own engines are left out
  std::string device;        // part of the Vulkan device's name
  std::function<void(double fraction, std::string_view stage)> progress;  // may be empty
};

struct EngineRow {
  std::string engine;
  bool on_device = false;  // else on the CPU
  BuildFigures figures;
  double median_ms = 0;
  double best_ms = 0;
  Comparison comparison;
};

struct TraceBenchReport {
  std::string scene;
  bool any_hit = false;
  std::string device, driver;  // empty when no engine needs one
  double copy_gb_per_s = 0;    // of the device's memory, bytes read and bytes written both counted
  std::uint64_t rays = 0;
  std::uint64_t triangles = 0;
  std::uint64_t zones = 0;
  std::vector<EngineRow> rows;
  std::vector<std::string> left_out;  // "engine: why"
};

// OK, or an error that names the unknown engine and the known ones.
Status check_engine_names(std::span<const std::string> names);

Result<TraceBenchReport> run_trace_bench(const BenchScene& scene, const Oracle& oracle, std::span<const BenchRay> rays,
                                         const TraceBenchOptions& options);

std::string trace_table(const TraceBenchReport& report);
nlohmann::ordered_json trace_json(const TraceBenchReport& report);

}  // namespace zc::bench
