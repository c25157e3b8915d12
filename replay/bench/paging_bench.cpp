// SPDX-License-Identifier: Apache-2.0
#include "replay/bench/paging_bench.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "replay/bench/engines/stopwatch.h"
#include "replay/bench/print_figures.h"
#include "replay/paths/world_tour.h"
#include "streamer/open_source.h"
#include "streamer/paging/memory_plan.h"
#include "streamer/paging/rendered_cut.h"
#include "streamer/paging/selection.h"
#include "streamer/source/index_file.h"
#include "streamer/source/source.h"

namespace zc::bench {
namespace {

constexpr double kSpeed_m_per_s = 300 / 3.6;
constexpr double kFramesPerSecond = 30;
constexpr std::uint32_t kViews = 9;  // as `replay`: now and two seconds ahead
constexpr double kLookAhead_s = 2;
constexpr std::int32_t kLeafSide = 250 << 8;

std::vector<View> views_at(const WorldIndex& index, unsigned frame, unsigned frames) {
  const auto [low, high] = world_bounds(index);
  const glm::dvec3 size = high - low;
  // Through the middle, along the diagonal.
  const double half_m = kSpeed_m_per_s * frames / kFramesPerSecond / 2;
  std::vector<View> views;
  for (std::uint32_t v = 0; v < kViews; ++v) {
    const double at_s = frame / kFramesPerSecond + kLookAhead_s * v / (kViews - 1);
    const double along_m = (kSpeed_m_per_s * at_s - half_m) / std::sqrt(2.0);
    views.push_back({{low.x + size.x / 2 + along_m, low.y + size.y / 2 + along_m, low.z + 2}, v});
  }
  return views;
}

}  // namespace

WorldIndex make_synthetic_index(std::uint32_t nodes) {
  std::uint32_t depth = 0;
  for (std::uint64_t level = 1, sum = 1; sum < nodes; sum += level) {
    level *= 4;
    ++depth;
  }
  WorldIndex index;
  index.materials.resize(1);
  index.header.bounds_max = {kLeafSide << depth, kLeafSide << depth, 50 << 8};
  index.nodes.reserve(nodes);
  std::mt19937 random(1);
  const auto add = [&](std::int32_t parent, std::uint32_t level, std::uint32_t x, std::uint32_t y) {
    NodeRecord node;
    node.parent = parent;
    node.depth = level;
    node.cell_x = x;
    node.cell_y = y;
    node.step_shift = depth - level;
    const std::int32_t side = kLeafSide << (depth - level);
    node.origin = {static_cast<std::int32_t>(x) * side, static_cast<std::int32_t>(y) * side, 0};
    node.bounds_min = node.origin;
    node.bounds_max = {node.origin[0] + side, node.origin[1] + side, 50 << 8};
    node.error_max_m = std::ldexp(0.1F, static_cast<int>(depth - level));
    node.triangle_count = 800 + static_cast<std::uint32_t>(random() % 1600);
    node.vertex_count = node.reference_count = node.triangle_count;
    node.primitive_count = 1;
    node.bvh_node_count = node.triangle_count / 8;
    node.bvh_depth = 8;
    node.page_bytes = node.triangle_count * 25 / 32 * 32;
    node.scratch_bytes = node.triangle_count * 300;
    node.glb_bytes = node.triangle_count * 6ULL;
    node.bvh_bytes = node.triangle_count * 2ULL;
    index.nodes.push_back(node);
  };
  add(-1, 0, 0, 0);
  for (std::uint32_t n = 0; index.nodes.size() < nodes; ++n) {
    const NodeRecord parent = index.nodes[n];
    index.nodes[n].first_child = static_cast<std::uint32_t>(index.nodes.size());
    index.nodes[n].child_count = std::min<std::uint32_t>(4, nodes - index.nodes[n].first_child);
    for (std::uint32_t c = 0; c < index.nodes[n].child_count; ++c)
      add(static_cast<std::int32_t>(n), parent.depth + 1, 2 * parent.cell_x + c % 2, 2 * parent.cell_y + c / 2);
  }
  return index;
}

Result<PagingReport> run_paging_bench(std::string scene, const std::filesystem::path& world,
                                      const PagingBenchOptions& options) {
  PagingReport report;
  report.scene = std::move(scene);
  WorldIndex index;
  std::vector<double> opening;
  for (unsigned r = 0; r < options.repeat; ++r) {
    index = {};
    const Stopwatch watch;
    ZC_ASSIGN(const std::unique_ptr<Source> source, open_source(world, options.source));
    ZC_ASSIGN(index, read_world_index(*source, world));
    StreamerOptions paging;
    paging.cap_bytes = smallest_cap_bytes(index) + 2 * options.pool_bytes;
    ZC_ASSIGN([[maybe_unused]] const MemoryPlan plan, plan_memory(index, paging));
    opening.push_back(watch.ms());
  }
  report.open_ms = median(opening);
  report.nodes = index.nodes.size();
  report.index_bytes = index.resident_bytes();

  Selection selection;
  std::vector<std::uint8_t> marks(index.nodes.size());
  std::vector<std::uint32_t> marked;
  RenderedCut resident(index);  // at once what is selected
  std::vector<std::uint32_t> before;
  std::vector<double> times;
  std::vector<double> counts;
  for (unsigned f = 0; f < options.frames; ++f) {
    const std::vector<View> views = views_at(index, f, options.frames);
    const Stopwatch watch;
    select_nodes(index,
                 {.views = views,
                  .previous = marks,
                  .cut = &resident,
                  .budget_bytes = std::max(options.pool_bytes, pool_bytes(index.nodes[0])),
                  .tolerance = options.tolerance},
                 selection);
    mark_selection(selection, marks, marked);
    for (const std::uint32_t n : before)
      if ((marks[n] & kMarkSelected) == 0) resident.remove(n);
    for (const std::uint32_t n : selection.nodes)
      if (!resident.resident(n)) resident.add(n);
    [[maybe_unused]] const WantedCount wanted = count_wanted(index, views, options.tolerance, false, resident);
    times.push_back(watch.ms());
    before = selection.nodes;
    counts.push_back(static_cast<double>(before.size()));
  }
  report.selected_nodes = median(counts);
  std::ranges::sort(times);
  report.select_ms = median(times);
  report.select_p95_ms = times[(times.size() * 95 - 1) / 100];
  return report;
}

std::string paging_table(const std::vector<PagingReport>& reports) {
  std::string text = format("%-20s %10s %12s %9s %10s %9s %9s\n", "scene", "nodes", "index bytes", "open ms",
                            "select ms", "p95 ms", "selected");
  for (const PagingReport& r : reports)
    text += format("%-20s %10llu %12llu %9.2f %10.4f %9.4f %9.0f\n", r.scene.c_str(),
                   static_cast<unsigned long long>(r.nodes), static_cast<unsigned long long>(r.index_bytes), r.open_ms,
                   r.select_ms, r.select_p95_ms, r.selected_nodes);
  return text;
}

nlohmann::ordered_json paging_json(const std::vector<PagingReport>& reports) {
  nlohmann::ordered_json json;
  json["rows"] = nlohmann::ordered_json::array();
  for (const PagingReport& r : reports) {
    json["rows"].push_back({{"case", r.scene},
                            {"engine", "zonecast"},
                            {"nodes", r.nodes},
                            {"index_bytes", r.index_bytes},
                            {"open_ms", r.open_ms},
                            {"select_ms", r.select_ms},
                            {"select_p95_ms", r.select_p95_ms},
                            {"selected_nodes", r.selected_nodes}});
  }
  return json;
}

}  // namespace zc::bench
