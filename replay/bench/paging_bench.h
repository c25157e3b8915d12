// SPDX-License-Identifier: Apache-2.0
// What the size of a world costs: reading its index and planning its memory, and choosing what should be resident frame
// by frame, on a flight across it at 300 km/h with nine views a frame.
// Units: milliseconds, bytes. Threads: one. Deterministic but for the times. Fails when files do.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/result.h"
#include "streamer/source/source.h"
#include "streamer/world_format/world_index.h"

namespace zc::bench {

struct PagingBenchOptions {
  std::uint64_t pool_bytes = 128ULL << 20U;
  unsigned frames = 601;
  unsigned repeat = 5;  // of opening
  double tolerance = 0.002;
  SourceOptions source;
};

struct PagingReport {
  std::string scene;
  std::uint64_t nodes = 0;
  std::uint64_t index_bytes = 0;
  double open_ms = 0;  // median: read, checked, planned
  double select_ms = 0;
  double select_p95_ms = 0;
  double selected_nodes = 0;  // median
};

// A quadtree of exactly `nodes` nodes over leaves of 250 m, pages of 20 to 60 kB, errors that halve from level to
// level: an index alone, without zones.
WorldIndex make_synthetic_index(std::uint32_t nodes);

// Of a world, of which the index alone is read.
Result<PagingReport> run_paging_bench(std::string scene, const std::filesystem::path& world,
                                      const PagingBenchOptions& options);

std::string paging_table(const std::vector<PagingReport>& reports);
nlohmann::ordered_json paging_json(const std::vector<PagingReport>& reports);

}  // namespace zc::bench
