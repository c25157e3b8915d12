// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/appearance/city_appearance.h"

#include <algorithm>

#include "baker/appearance/zone_appearance.h"

namespace zc {
namespace {

// Of the coarsest levels, in texels.
constexpr std::uint32_t kSmallestAtlas = 32;

// How many levels of proxies lie below each node.
std::vector<std::uint32_t> heights(std::span<const NodeRecord> nodes) {
  std::vector<std::uint32_t> height(nodes.size());
  for (std::size_t i = nodes.size(); i-- > 1;)  // children lie behind their parents
    if (!nodes[i].is_detail()) {
      std::uint32_t& above = height[static_cast<std::size_t>(nodes[i].parent)];
      above = std::max(above, height[i] + 1);
    }
  return height;
}

}  // namespace

Result<CityAppearance> make_appearances(AppearanceInput&& input, BakeContext& context) {
  const std::size_t count = input.nodes.size();
  context.begin(BakeStage::kAtlas, count);
  CityAppearance out;
  out.zones.resize(count);
  if (input.atlas_size == 0) return out;
  for (const std::uint32_t height : heights(input.nodes))
    out.atlas_sizes.push_back(std::max(input.atlas_size >> height, kSmallestAtlas));
  if (input.textures.empty()) return out;
  ZC_TRY(context.for_each(count, [&](std::size_t i) -> Status {
    out.zones[i] = make_zone_appearance(input.meshes[i], input.nodes[i], input.textures, input.materials, input.step_m,
                                        {.max_size = out.atlas_sizes[i]});
    return {};
  }));
  return out;
}

}  // namespace zc
