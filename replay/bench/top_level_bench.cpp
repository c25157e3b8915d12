// SPDX-License-Identifier: Apache-2.0
#include "replay/bench/top_level_bench.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <set>
#include <utility>

#include "base/check.h"
#include "replay/bench/engines/stopwatch.h"
#include "replay/bench/print_figures.h"
#include "runtime/scene/zone_set.h"
#include "shaders/shared/page_node.h"
#include "streamer/open_source.h"
#include "streamer/paging/page_loader.h"
#include "streamer/source/index_file.h"
#include "streamer/world_format/page_view.h"

namespace zc::bench {
namespace {

RootPage cut_to_root(std::span<const std::uint32_t> page) {
  gpu::PageHeader header = PageView(page).header();
  const PageRoot root = page_root(page);
  const std::size_t children = root.child_count;
  RootPage out(gpu::kPageHeaderWords + (1 + children) * gpu::kPageNodeWords);
  header.total_words = static_cast<std::uint32_t>(out.size());
  std::memcpy(out.data(), &header, sizeof header);
  gpu::PageNode node;
  std::memcpy(&node, page.data() + gpu::kPageHeaderWords, sizeof node);
  if (children > 0) node.child_offset = gpu::kPageNodeWords;
  std::memcpy(out.data() + gpu::kPageHeaderWords, &node, sizeof node);
  std::memcpy(out.data() + gpu::kPageHeaderWords + gpu::kPageNodeWords, page.data() + root.child_words,
              children * sizeof(gpu::PageNode));
  return out;
}

template <class Visit>
void each_node(RootPage& page, const Visit& visit) {
  for (std::size_t at = gpu::kPageHeaderWords; at < page.size(); at += gpu::kPageNodeWords) {
    gpu::PageNode node;
    std::memcpy(&node, page.data() + at, sizeof node);
    visit(node);
    std::memcpy(page.data() + at, &node, sizeof node);
  }
}

TopLevelRow make_row(std::string engine, std::vector<double> times) {
  std::ranges::sort(times);
  return {std::move(engine), times[times.size() / 2], times[(times.size() * 95 - 1) / 100]};
}

// One zone is missing each time, another one than before.
Result<TopLevelRow> time_show(std::span<const RootPage> pages, std::span<const std::uint32_t> words,
                              std::uint32_t pool_words, const TopLevelBenchOptions& options) {
  DeviceOptions wanted;
  wanted.name = options.device;
  ZC_ASSIGN(const std::unique_ptr<Device> device, Device::create(wanted));
  ZoneSet set(*device);
  ZC_TRY(set.create(pool_words, static_cast<std::uint32_t>(pages.size())));
  for (std::size_t i = 0; i < pages.size(); ++i) ZC_TRY(set.upload(words[i], pages[i]));
  std::vector<ShownPage> zones;
  std::vector<double> times;
  for (unsigned r = 0; r < options.repeat; ++r) {
    zones.clear();
    for (std::size_t i = 0; i < pages.size(); ++i)
      if (pages.size() == 1 || i != r * 7 % pages.size()) zones.push_back({words[i], 0, false});
    const Stopwatch watch;
    ZC_TRY(set.show(zones));
    times.push_back(watch.ms());
  }
  return make_row("show", std::move(times));
}

}  // namespace

Result<std::vector<RootPage>> load_root_pages(const std::filesystem::path& world, const SourceOptions& options) {
  ZC_ASSIGN(const std::unique_ptr<Source> source, open_source(world, options));
  ZC_ASSIGN(const WorldIndex index, read_world_index(*source, world));
  std::vector<RootPage> pages;
  for (std::uint32_t id = 0; id < index.nodes.size(); ++id) {
    const NodeRecord& node = index.nodes[id];
    if (node.is_detail() || (node.child_count > 0 && !index.nodes[node.first_child].is_detail())) continue;
    ZC_ASSIGN(const std::vector<std::uint32_t> page, load_page(*source, index, id));
    pages.push_back(cut_to_root(page));
  }
  if (pages.empty()) return Error{ErrorCode::kFormat, "has no proxies", world.string()};
  return pages;
}

std::vector<RootPage> repeat_root_pages(std::span<const RootPage> pages, std::size_t count) {
  ZC_CHECK(!pages.empty());
  NodeBox all;
  for (const RootPage& page : pages) {
    RootPage copy = page;
    each_node(copy,
              [&](const gpu::PageNode& node) { all.add(bounds_of_slots(node, inner_mask(node) | leaf_mask(node))); });
  }
  std::size_t side = 1;
  while (side * side * pages.size() < count) ++side;
  std::vector<RootPage> out;
  out.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto round = i / pages.size();
    const auto x = static_cast<std::int32_t>(round % side) * (all.max[0] - all.min[0]);
    const auto y = static_cast<std::int32_t>(round / side) * (all.max[1] - all.min[1]);
    out.push_back(pages[i % pages.size()]);
    each_node(out.back(), [&](gpu::PageNode& node) {
      node.origin_x += x;
      node.origin_y += y;
    });
  }
  return out;
}

double top_level_cost(std::span<const gpu::PageNode> nodes, std::span<const TracedPage> pages,
                      std::uint32_t first_word) {
  std::set<std::uint32_t> children_of_roots;  // where they begin: whose copy a leaf of the top level is
  for (const TracedPage& page : pages)
    if (page.root->child_count > 0) children_of_roots.insert(page.page_word + page.root->child_words);
  double sum = 0;
  for (std::uint32_t i = 0; i < nodes.size(); ++i) {
    const gpu::PageNode& node = nodes[i];
    const std::uint32_t child_word = first_word + i * gpu::kPageNodeWords + node.child_offset;
    if (inner_mask(node) == 0 || (child_word < first_word && !children_of_roots.contains(child_word))) continue;
    for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot)
      if ((inner_mask(node) >> slot & 1U) != 0) sum += bounds_of_slots(node, 1U << slot).half_area();
  }
  const NodeBox all = nodes.empty() ? NodeBox{} : bounds_of_slots(nodes[0], inner_mask(nodes[0]));
  return all.half_area() > 0 ? 1 + sum / all.half_area() : 1;
}

Result<TopLevelReport> run_top_level_bench(std::string scene, std::span<const RootPage> pages,
                                           const TopLevelBenchOptions& options) {
  std::vector<PageRoot> roots;
  std::vector<std::uint32_t> words;
  std::uint32_t at = 0;
  for (const RootPage& page : pages) {
    roots.push_back(page_root(page));
    words.push_back(at);
    at += static_cast<std::uint32_t>(page.size());
  }
  std::vector<TracedPage> traced;
  for (std::size_t i = 0; i < roots.size(); ++i)
    traced.push_back(traced_page(words[i], roots[i], std::as_bytes(std::span(pages[i])).data()));

  TopLevelReport report;
  report.scene = std::move(scene);
  report.zones = pages.size();
  std::vector<double> times;
  TopLevelBuilder top;
  for (unsigned r = 0; r < options.repeat; ++r) {
    const Stopwatch watch;
    top.build(traced, at);
    times.push_back(watch.ms());
  }
  report.nodes = top.nodes().size();
  report.depth = top.depth();
  report.cost = top_level_cost(top.nodes(), traced, at);
  report.rows.push_back(make_row("top_level", std::move(times)));
  Result<TopLevelRow> show = time_show(pages, words, at, options);
  if (show) {
    report.rows.push_back(*std::move(show));
  } else if (!options.device.empty()) {
    return std::move(show).error();
  } else {
    report.left_out.push_back("show: " + show.error().describe());
  }
  return report;
}

std::string top_level_table(const TopLevelReport& report) {
  std::string text = report.scene + ": " + std::to_string(report.zones) + " zones, " + std::to_string(report.nodes) +
                     " nodes, depth " + std::to_string(report.depth);
  text += format(", %.2f nodes a ray\n%-16s %9s %9s\n", report.cost, "engine", "build ms", "p95 ms");
  for (const TopLevelRow& row : report.rows)
    text += format("%-16s %9.4f %9.4f\n", row.engine.c_str(), row.median_ms, row.p95_ms);
  for (const std::string& cause : report.left_out) text += "left out: " + cause + '\n';
  return text;
}

nlohmann::ordered_json top_level_json(const TopLevelReport& report) {
  nlohmann::ordered_json json = {{"zones", report.zones}, {"left_out", report.left_out}};
  json["rows"] = nlohmann::ordered_json::array();
  for (const TopLevelRow& row : report.rows) {
    json["rows"].push_back({{"case", report.scene},
                            {"engine", row.engine},
                            {"build_ms", row.median_ms},
                            {"p95_ms", row.p95_ms},
                            {"nodes", report.nodes},
                            {"depth", report.depth},
                            {"cost", report.cost}});
  }
  return json;
}

}  // namespace zc::bench
