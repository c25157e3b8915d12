// SPDX-License-Identifier: Apache-2.0
// What it costs to rebuild the top level when residency changes: the build alone, and ZoneSet::show with its
// look-ups and uploads.
// Units: milliseconds; cost as below. Borrows what it is given. Threads: one at a time. Deterministic but for the
// times. Fails when a page of the world cannot be loaded, when it has none, or when the driver refuses.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "runtime/scene/top_level.h"
#include "streamer/source/source.h"

namespace zc::bench {

// What the top level takes of a page, as a page of its own: header, root and the root's child nodes.
using RootPage = std::vector<std::uint32_t>;

// Of the world's finest proxies, in the order of its index.
Result<std::vector<RootPage>> load_root_pages(const std::filesystem::path& world, const SourceOptions& options = {});

// Exactly `count`: the first ones, or all of them again and again, each round in a place of its own beside the others.
std::vector<RootPage> repeat_root_pages(std::span<const RootPage> pages, std::size_t count);

// Nodes that a random ray through the top level's box visits, by the surface area heuristic: those of the top level,
// the pages' roots and the roots' children. Pages opened or not thus compare.
double top_level_cost(std::span<const gpu::PageNode> nodes, std::span<const TracedPage> pages,
                      std::uint32_t first_word);

struct TopLevelBenchOptions {
  unsigned repeat = 201;
  std::string device;  // part of the Vulkan device's name
};

struct TopLevelRow {
  std::string engine;
  double median_ms = 0;
  double p95_ms = 0;
};

struct TopLevelReport {
  std::string scene;
  std::size_t zones = 0;
  std::size_t nodes = 0;
  std::uint32_t depth = 0;  // with the pages below
  double cost = 0;
  std::vector<TopLevelRow> rows;
  std::vector<std::string> left_out;  // "engine: why"
};

Result<TopLevelReport> run_top_level_bench(std::string scene, std::span<const RootPage> pages,
                                           const TopLevelBenchOptions& options);

std::string top_level_table(const TopLevelReport& report);
nlohmann::ordered_json top_level_json(const TopLevelReport& report);

}  // namespace zc::bench
