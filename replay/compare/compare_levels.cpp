// SPDX-License-Identifier: Apache-2.0
#include "replay/compare/compare_levels.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <utility>

#include "replay/compare/format_text.h"
#include "replay/compare/level_source.h"
#include "replay/paths/spread_evenly.h"

namespace zc {
namespace {

constexpr double kRefineAll = 1e-9;  // tolerance

// "12,345"
std::string with_commas(std::uint64_t value) {
  std::string text = std::to_string(value);
  for (std::size_t at = text.size(); at > 3;) text.insert(at -= 3, 1, ',');
  return text;
}

// A bound: rounded up.
std::string metres(double value) {
  const double parts = value < 1 ? 100 : value < 10 ? 10 : 1;
  return format_text(value < 1 ? "%.2f m" : value < 10 ? "%.1f m" : "%.0f m", std::ceil(value * parts) / parts);
}

CompareLevel source_level(const WorldIndex& index) {
  CompareLevel level;
  level.row.name = "source";
  level.tolerance = kRefineAll;
  level.is_source = true;
  level.column = {"source", {"the full detail", with_commas(index.header.source_triangles) + " triangles"}};
  return level;
}

CompareLevel stored_level(const WorldIndex& index, std::uint32_t depth, bool finest) {
  CompareLevel level;
  level.row.name = finest ? "finest" : "level_" + std::to_string(depth);
  level.row.depth = depth;
  level.tolerance = kRefineAll;
  level.cut = cut_at_depth(index, depth);
  std::uint64_t triangles = 0;
  for (const NodeRecord& node : level.cut->nodes) {
    if (node.child_count > 0) continue;
    triangles += node.triangle_count;
    level.row.error_max_m = std::max(level.row.error_max_m, static_cast<double>(node.error_max_m));
  }
  level.column.title = finest ? format_text("finest proxies (level %u)", depth)
                              : format_text(depth == 0 ? "level %u, the coarsest" : "level %u", depth);
  level.column.lines = {"within " + metres(level.row.error_max_m) + " of the source",
                        with_commas(triangles) + " triangles"};
  return level;
}

CompareLevel paged_level(double tolerance) {
  CompareLevel level;
  level.row.name = "tolerance_" + format_text("%g", tolerance);
  level.row.tolerance = level.tolerance = tolerance;
  level.column = {"what a replay pages", {format_text("--tolerance %g:", tolerance), "finer where it is near"}};
  return level;
}

}  // namespace

std::vector<CompareLevel> levels_of(const WorldIndex& index, const std::vector<double>& tolerances) {
  std::vector<CompareLevel> levels = {source_level(index)};
  std::set<std::uint32_t, std::greater<>> stored;
  for (const NodeRecord& node : index.nodes)
    if (!node.is_detail()) stored.insert(node.depth);
  const std::vector<std::uint32_t> depths(stored.begin(), stored.end());
  for (const std::size_t i : spread_evenly(depths.size(), kSheetLevelLimit))
    levels.push_back(stored_level(index, depths[i], i == 0));
  for (const double tolerance : tolerances) levels.push_back(paged_level(tolerance));
  return levels;
}

}  // namespace zc
