// SPDX-License-Identifier: Apache-2.0
// Times tree builders over the same zones, in turn, and tabulates what they took and what their trees cost.
// Units: milliseconds of wall clock; millions of triangles a second; bytes; costs as the builders' owner defines them.
// Borrows what it is given. Threads: zones are built on `threads` of them.
// Fails when a builder that was asked for by name is not there, and when one fails.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace zc::bench {

// Of the tree of one zone.
struct TreeFigures {
  std::uint64_t nodes = 0;
  std::uint64_t references = 0;
  std::uint32_t depth = 0;
  std::uint64_t page_bytes = 0;
  double sah_cost = 0;           // of a random ray that hits the zone's box
  double ray_cost = 0;           // of a representative ray
  std::uint64_t mismatches = 0;  // representative rays that do not find the nearest triangle
};

using TreeProbe = std::function<Result<TreeFigures>()>;

struct TreeBuilder {
  std::string name;
  // Builds the tree of a zone, which is timed; what it returns looks at the tree, which is not. Called from several
  // threads at once. Empty where the builder is missing.
  std::function<Result<TreeProbe>(std::size_t zone)> build;
  std::string missing = {};  // why
};

struct BuildBenchOptions {
  std::vector<std::string> engines;  // empty: all that are there
  unsigned repeat = 5;
  unsigned threads = 2;
  std::function<void(double fraction, std::string_view stage)> progress;  // may be empty
};

struct BuildRow {
  std::string engine;
  double median_ms = 0;
  double best_ms = 0;
  double median_cpu_ms = 0;  // of all threads; says what a core does where other work shares the machine
  TreeFigures sum;           // over all zones; of depths the greatest
};

struct BuildBenchReport {
  std::string scene;
  std::uint64_t triangles = 0;
  std::uint64_t zones = 0;
  unsigned threads = 0;
  std::vector<BuildRow> rows;
  std::vector<std::string> left_out;  // "engine: why"
};

// OK, or an error that names the engine that is unknown or missing here.
Status check_builders(const std::vector<TreeBuilder>& builders, const std::vector<std::string>& engines);

// An engine whose trees a page cannot hold is left out, unless it was asked for by name.
Result<BuildBenchReport> run_build_bench(std::string scene, std::uint64_t triangles, std::size_t zones,
                                         const std::vector<TreeBuilder>& builders, const BuildBenchOptions& options);

std::string build_table(const BuildBenchReport& report);
nlohmann::ordered_json build_json(const BuildBenchReport& report);

}  // namespace zc::bench
