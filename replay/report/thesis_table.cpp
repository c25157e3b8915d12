// SPDX-License-Identifier: Apache-2.0
#include "replay/report/thesis_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>

#include "shaders/shared/page.h"

namespace zc {
namespace {

using Json = nlohmann::ordered_json;

struct Zones {
  std::uint64_t zones = 0, triangles = 0;
  double texture = 0, bvh = 0, triangle = 0, normals = 0, uv = 0, light = 0;  // bytes of all

  [[nodiscard]] Json to_json(const Json& bvh_build_s) const {
    const double count = static_cast<double>(std::max<std::uint64_t>(zones, 1));
    const auto average = [&](double bytes) { return std::llround(bytes / count); };
    const double geometry = bvh + triangle + normals + uv + light;
    return {{"zones", zones},
            {"triangles", triangles},
            {"zone_bytes",
             {{"texture", average(texture)},
              {"bvh", average(bvh)},
              {"triangles", average(triangle)},
              {"normals", average(normals)},
              {"uv", average(uv)},
              {"light", average(light)},
              {"total", average(geometry + texture)}}},
            {"bytes_per_triangle", geometry / static_cast<double>(std::max<std::uint64_t>(triangles, 1))},
            {"bvh_build_s", bvh_build_s}};
  }
};

Zones thesis() {
  Zones t{.zones = 167, .triangles = 627'411};
  const double zones = static_cast<double>(t.zones);
  t.texture = 786'432 * zones;
  t.bvh = 155'250 * zones;
  t.triangle = (2 * 15'028 + 45'084) * zones;  // index, delta and edge
  t.normals = 45'084 * zones;
  t.uv = 30'056 * zones;
  return t;
}

Zones leaf_proxies(const WorldIndex& index) {
  Zones sum;
  for (const NodeRecord& node : index.nodes) {
    if (node.is_detail() || node.child_count != 1 || !index.nodes[node.first_child].is_detail()) continue;
    ++sum.zones;
    sum.triangles += node.triangle_count;
    const std::uint64_t bvh = sizeof(gpu::PageHeader) + std::uint64_t{node.bvh_node_count} * sizeof(gpu::PageNode);
    const std::uint64_t rest =
        std::uint64_t{node.appearance_bytes} + node.light_bytes + node.normal_bytes + node.texture_bytes;
    sum.texture += node.texture_bytes;
    sum.bvh += static_cast<double>(bvh);
    sum.triangle += static_cast<double>(node.page_bytes - std::min<std::uint64_t>(node.page_bytes, bvh + rest));
    sum.normals += node.normal_bytes;
    sum.uv += node.appearance_bytes;
    sum.light += node.light_bytes;
  }
  return sum;
}

}  // namespace

Json thesis_table(const WorldIndex& index, const Json& bvh_build_s) {
  return {{"thesis", thesis().to_json(453)}, {"world", leaf_proxies(index).to_json(bvh_build_s)}};
}

void print_thesis_table(std::ostream& out, const Json& table) {
  const auto row = [&](const std::string& name, const Json& ours, const Json& theirs, int digits) {
    out << std::left << std::setw(34) << name << std::right << std::fixed << std::setprecision(digits);
    for (const Json& value : {theirs, ours}) {
      if (value.is_number())
        out << std::setw(12) << value.get<double>();
      else
        out << std::setw(12) << "-";
    }
    out << '\n';
  };
  const Json& theirs = table["thesis"];
  const Json& ours = table["world"];
  out << std::left << std::setw(34) << "leaf proxies" << std::right << std::setw(12) << "thesis 4.1" << std::setw(12)
      << "here" << '\n';
  row("zones", ours["zones"], theirs["zones"], 0);
  row("triangles", ours["triangles"], theirs["triangles"], 0);
  constexpr std::array<std::array<const char*, 2>, 7> kParts = {{{"texture", "texture"},
                                                                 {"bvh", "BVH"},
                                                                 {"triangles", "triangles (index, delta, edge)"},
                                                                 {"normals", "normals"},
                                                                 {"uv", "UV"},
                                                                 {"light", "light"},
                                                                 {"total", "total"}}};
  out << "bytes of an average zone\n";
  for (const auto& [key, name] : kParts)
    row(std::string("  ") + name, ours["zone_bytes"][key], theirs["zone_bytes"][key], 0);
  row("bytes a triangle without texture", ours["bytes_per_triangle"], theirs["bytes_per_triangle"], 1);
  row("BVH build, s (here: all levels)", ours["bvh_build_s"], theirs["bvh_build_s"], 2);
}

}  // namespace zc
