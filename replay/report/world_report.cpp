// SPDX-License-Identifier: Apache-2.0
#include "replay/report/world_report.h"

#include <algorithm>
#include <map>

#include "replay/paths/world_tour.h"
#include "replay/report/thesis_table.h"
#include "shaders/shared/page.h"
#include "streamer/paging/memory_plan.h"
#include "streamer/paging/page_loader.h"
#include "streamer/streamer.h"

namespace zc {
namespace {

constexpr const char* kBakeReport = "bake.json";

struct Level {
  std::uint64_t nodes = 0, triangles = 0, bvh_nodes = 0, page_bytes = 0;
  std::uint64_t appearance_bytes = 0, light_bytes = 0, normal_bytes = 0, texture_bytes = 0;
  std::uint64_t glb_bytes = 0, zbvh_bytes = 0;
  double error_max_m = 0, error_sum_m = 0, appearance_max_m = 0;

  void add(const NodeRecord& node) {
    ++nodes;
    triangles += node.triangle_count;
    bvh_nodes += node.bvh_node_count;
    page_bytes += node.page_bytes;
    appearance_bytes += node.appearance_bytes;
    light_bytes += node.light_bytes;
    normal_bytes += node.normal_bytes;
    texture_bytes += node.texture_bytes;
    glb_bytes += node.glb_bytes;
    zbvh_bytes += node.bvh_bytes;
    error_max_m = std::max(error_max_m, static_cast<double>(node.error_max_m));
    appearance_max_m = std::max(appearance_max_m, static_cast<double>(node.appearance_error_m));
    error_sum_m += static_cast<double>(node.error_mean_m) * node.triangle_count;
  }

  [[nodiscard]] double per_triangle(double value) const {
    return value / static_cast<double>(std::max<std::uint64_t>(triangles, 1));
  }

  // Resident, without the index.
  [[nodiscard]] nlohmann::ordered_json parts() const {
    const std::uint64_t tree_bytes = nodes * sizeof(gpu::PageHeader) + bvh_nodes * sizeof(gpu::PageNode);
    const std::uint64_t rest = tree_bytes + appearance_bytes + light_bytes + normal_bytes + texture_bytes;
    return {{"nodes", tree_bytes},
            {"triangles", page_bytes - std::min(page_bytes, rest)},  // clusters: triangles, vertices, materials
            {"normals", normal_bytes},
            {"uv", appearance_bytes},  // charts stand in for coordinates
            {"light", light_bytes},
            {"texture", texture_bytes}};
  }

  [[nodiscard]] nlohmann::ordered_json to_json() const {
    nlohmann::ordered_json bytes = parts();
    bytes["index"] = nodes * sizeof(NodeRecord);
    return {{"nodes", nodes},
            {"triangles", triangles},
            {"bytes", std::move(bytes)},
            {"bytes_per_triangle", per_triangle(static_cast<double>(page_bytes))},
            {"error_m_max", error_max_m},
            {"error_m_mean", per_triangle(error_sum_m)},
            {"appearance_error_m_max", appearance_max_m}};
  }

  [[nodiscard]] nlohmann::ordered_json parts_per_triangle() const {
    nlohmann::ordered_json json = parts();
    for (auto& bytes : json) bytes = per_triangle(bytes.get<double>());
    json["total"] = per_triangle(static_cast<double>(page_bytes));
    return json;
  }

  // On the disk. `baked`: what the bake reports of these files' insides, or nothing.
  [[nodiscard]] nlohmann::ordered_json disk_per_triangle(const nlohmann::ordered_json& baked) const {
    const std::uint64_t index_bytes = nodes * sizeof(NodeRecord);
    nlohmann::ordered_json json;
    for (const char* part : {"mesh", "json", "tree", "materials", "looks", "light", "normals", "texture"}) {
      const auto bytes = baked.is_object() ? baked.find(part) : baked.end();
      if (bytes == baked.end() || !bytes->is_number_unsigned()) {
        json = {{"glb", per_triangle(static_cast<double>(glb_bytes))},
                {"zbvh", per_triangle(static_cast<double>(zbvh_bytes))}};
        break;
      }
      json[part] = per_triangle(bytes->get<double>());
    }
    json["index"] = per_triangle(static_cast<double>(index_bytes));
    json["total"] = per_triangle(static_cast<double>(glb_bytes + zbvh_bytes + index_bytes));
    return json;
  }
};

// Empty where there is none that can be read.
nlohmann::ordered_json read_bake_report(Source& source) {
  const auto bake = source.read_all(kBakeReport, 1 << 20);
  if (!bake) return nlohmann::ordered_json::object();
  const auto* text = reinterpret_cast<const char*>(bake->data());
  auto report = nlohmann::ordered_json::parse(text, text + bake->size(), nullptr, false);
  return report.is_object() ? report : nlohmann::ordered_json::object();
}

// As the bake reports it; entries of another form are not passed on.
nlohmann::ordered_json left_out_of(const nlohmann::ordered_json& report) {
  auto out = nlohmann::ordered_json::array();
  const auto all = report.find("left_out");
  if (all == report.end() || !all->is_array()) return out;
  for (const auto& entry : *all) {
    if (!entry.is_object() || !entry.contains("what") || !entry["what"].is_string()) continue;
    const auto counts = {"count", "page_bytes", "disk_bytes"};
    nlohmann::ordered_json kept = {{"what", entry["what"]}};
    for (const char* key : counts)
      if (entry.contains(key) && entry[key].is_number_unsigned()) kept[key] = entry[key];
    if (kept.contains("count") && kept.contains("page_bytes")) out.push_back(std::move(kept));
  }
  return out;
}

}  // namespace

nlohmann::ordered_json describe_world(Source& source, const WorldIndex& index) {
  std::map<std::uint32_t, Level> levels;
  Level detail, proxies;
  std::uint64_t zones = 0, decoded = 0, glb = 0, zbvh = 0;
  for (const NodeRecord& node : index.nodes) {
    glb += node.glb_bytes;
    zbvh += node.bvh_bytes;
    if (node.is_detail()) {
      ++zones;  // every zone has its full detail under it
      detail.add(node);
    } else {
      decoded += node.page_bytes;
      levels[node.depth].add(node);
      proxies.add(node);
    }
  }
  nlohmann::ordered_json json;
  json["zones"] = zones;
  json["nodes"] = index.nodes.size();
  json["source_triangles"] = index.header.source_triangles;
  json["crs"] = index.crs;
  const Bounds bounds = world_bounds(index);
  json["bounds_m"] = {{"min", {bounds.min.x, bounds.min.y, bounds.min.z}},
                      {"max", {bounds.max.x, bounds.max.y, bounds.max.z}}};
  json["decoded_bytes"] = decoded;
  json["smallest_cap_bytes"] = smallest_cap_bytes(index, source.costs());
  json["levels"] = nlohmann::ordered_json::array();
  for (const auto& [depth, level] : levels) {
    nlohmann::ordered_json row = {{"depth", depth}, {"detail", false}};
    row.update(level.to_json());
    json["levels"].push_back(std::move(row));
  }
  nlohmann::ordered_json row = {{"depth", nullptr}, {"detail", true}};
  row.update(detail.to_json());
  json["levels"].push_back(std::move(row));
  json["resident_bytes_per_triangle"] = proxies.parts_per_triangle();
  json["disk_bytes"] = {{"glb", glb}, {"zbvh", zbvh}, {"index", encode_world_index(index).size()}};
  const nlohmann::ordered_json report = read_bake_report(source);
  const nlohmann::ordered_json disk = report.value("disk_bytes", nlohmann::ordered_json());
  json["disk_bytes_per_triangle"] = proxies.disk_per_triangle(
      disk.is_object() ? disk.value("proxies", nlohmann::ordered_json()) : nlohmann::ordered_json());
  json["left_out"] = left_out_of(report);
  if (report.value("bake_s", nlohmann::ordered_json()).is_object()) json["bake_s"] = report["bake_s"];
  json["table_4_1"] =
      thesis_table(index, json.value(nlohmann::ordered_json::json_pointer("/bake_s/bvh"), nlohmann::ordered_json()));
  return json;
}

std::vector<Error> verify_world(Source& source, const WorldIndex& index,
                                const std::function<void(double fraction, std::string_view stage)>& progress) {
  std::vector<Error> failures;
  for (std::uint32_t node = 0; node < index.nodes.size(); ++node) {
    const auto page = load_page(source, index, node);
    if (!page) failures.push_back(page.error());
    progress(static_cast<double>(node + 1) / static_cast<double>(index.nodes.size()), "verify");
  }
  return failures;
}

}  // namespace zc
