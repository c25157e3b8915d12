// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/appearance/atlas.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>

#include "streamer/world_format/page_view.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wshadow"
#define STB_RECT_PACK_IMPLEMENTATION
#define STBRP_STATIC
#include <stb/stb_rect_pack.h>
#define STB_DXT_IMPLEMENTATION
#define STB_DXT_STATIC
#include <stb/stb_dxt.h>
#pragma GCC diagnostic pop

namespace zc {
namespace {

constexpr std::int32_t kGutter = 2;
constexpr std::int32_t kBlock = 4;
constexpr std::uint32_t kMinSize = 1U << gpu::kAtlasMinLog2;
// The gutters of a third level would be half a texel.
constexpr std::uint32_t kMaxLevels = 3;
constexpr int kDensitySteps = 60;
constexpr double kTinyTexels = 2;

ChartRaster raster_of(const Chart& chart, double texels_per_step) {
  ChartRaster raster;
  raster.texels_per_step = texels_per_step;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const double low = std::floor(chart.min[axis] * texels_per_step);
    const double high = std::ceil(chart.max[axis] * texels_per_step);
    const auto texels = static_cast<std::int32_t>(std::max(high - low, 1.0)) + 2 * kGutter;
    raster.first[axis] = static_cast<std::int32_t>(low) - kGutter;
    raster.size[axis] = static_cast<std::uint32_t>((texels + kBlock - 1) / kBlock * kBlock);
  }
  return raster;
}

bool pack(std::vector<stbrp_rect>& rects, std::uint32_t width, std::uint32_t height) {
  std::vector<stbrp_node> nodes(width / kBlock);
  stbrp_context context;
  stbrp_init_target(&context, static_cast<int>(width / kBlock), static_cast<int>(height / kBlock), nodes.data(),
                    static_cast<int>(nodes.size()));
  return stbrp_pack_rects(&context, rects.data(), static_cast<int>(rects.size())) == 1;
}

std::optional<AtlasLayout> try_density(std::span<const Chart* const> charts, double texels_per_step,
                                       std::uint32_t max_size) {
  AtlasLayout layout;
  layout.texels_per_step = texels_per_step;
  std::vector<stbrp_rect> rects;
  std::uint64_t area = 0;
  std::uint32_t widest = kMinSize;
  std::uint32_t highest = kMinSize;
  for (std::size_t c = 0; c < charts.size(); ++c) {
    const Chart* chart = charts[c];
    layout.rasters.emplace_back();
    if (std::max(chart->max[0] - chart->min[0], chart->max[1] - chart->min[1]) * texels_per_step <= kTinyTexels)
      continue;
    const ChartRaster raster = raster_of(*chart, texels_per_step);
    if (raster.size[0] > max_size || raster.size[1] > max_size) return std::nullopt;
    area += std::uint64_t{raster.size[0]} * raster.size[1];
    widest = std::max(widest, raster.size[0]);
    highest = std::max(highest, raster.size[1]);
    stbrp_rect rect{};
    rect.id = static_cast<int>(c);
    rect.w = static_cast<stbrp_coord>(raster.size[0] / kBlock);
    rect.h = static_cast<stbrp_coord>(raster.size[1] / kBlock);
    rects.push_back(rect);
    layout.rasters.back() = raster;
  }
  if (rects.empty() || area > std::uint64_t{max_size} * max_size) return std::nullopt;
  // From small to large, the wider of two equal areas first.
  const std::uint32_t last = static_cast<std::uint32_t>(std::bit_width(max_size)) - 1;
  for (std::uint32_t area_log2 = 2 * gpu::kAtlasMinLog2; area_log2 <= 2 * last; ++area_log2) {
    const std::uint32_t width_log2 = (area_log2 + 1) / 2;
    layout.width = 1U << width_log2;
    layout.height = 1U << (area_log2 - width_log2);
    if (layout.width < widest || layout.height < highest) continue;
    if (area > std::uint64_t{layout.width} * layout.height) continue;
    if (!pack(rects, layout.width, layout.height)) continue;
    layout.place.resize(charts.size());
    for (const stbrp_rect& rect : rects)
      layout.place[static_cast<std::size_t>(rect.id)] = {static_cast<std::uint32_t>(rect.x * kBlock),
                                                         static_cast<std::uint32_t>(rect.y * kBlock)};
    return layout;
  }
  return std::nullopt;
}

struct Level {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<glm::vec3> color;
  std::vector<float> weight;  // share of the texel that a chart covers
};

Level halved(const Level& from) {
  Level to{from.width / 2, from.height / 2, {}, {}};
  to.color.resize(std::size_t{to.width} * to.height);
  to.weight.resize(to.color.size());
  for (std::uint32_t y = 0; y < to.height; ++y)
    for (std::uint32_t x = 0; x < to.width; ++x) {
      glm::vec3 sum(0);
      float weight = 0;
      for (std::uint32_t k = 0; k < 4; ++k) {
        const std::size_t at = std::size_t{2 * y + k / 2} * from.width + 2 * x + k % 2;
        sum += from.color[at] * from.weight[at];
        weight += from.weight[at];
      }
      const std::size_t i = std::size_t{y} * to.width + x;
      to.weight[i] = weight / 4;
      if (weight > 0) to.color[i] = sum / weight;
    }
  return to;
}

void append_blocks(const Level& level, std::vector<std::uint32_t>& out) {
  for (std::uint32_t by = 0; by < level.height; by += kBlock)
    for (std::uint32_t bx = 0; bx < level.width; bx += kBlock) {
      std::array<unsigned char, 64> rgba{};
      glm::vec3 mean(0);
      float weight = 0;
      const auto at = [&](std::uint32_t i) { return std::size_t{by + i / 4} * level.width + bx + i % 4; };
      for (std::uint32_t i = 0; i < 16; ++i) {
        mean += level.color[at(i)] * level.weight[at(i)];
        weight += level.weight[at(i)];
      }
      if (weight > 0) mean /= weight;
      for (std::uint32_t i = 0; i < 16; ++i) {
        const glm::vec3& c = level.weight[at(i)] > 0 ? level.color[at(i)] : mean;
        for (std::uint32_t k = 0; k < 3; ++k) rgba[4 * i + k] = linear_to_srgb8(c[static_cast<int>(k)]);
        rgba[4 * i + 3] = 255;
      }
      std::array<std::uint32_t, 2> block{};
      stb_compress_dxt_block(reinterpret_cast<unsigned char*>(block.data()), rgba.data(), 0, STB_DXT_HIGHQUAL);
      out.insert(out.end(), block.begin(), block.end());
    }
}

}  // namespace

std::optional<AtlasLayout> lay_out_atlas(std::span<const Chart* const> charts, double finest, std::uint32_t max_size) {
  for (int step = 0; step < kDensitySteps; ++step)
    // As the page contains it.
    if (const auto density = static_cast<float>(finest * std::exp2(-0.25 * step));
        auto layout = try_density(charts, density, max_size))
      return layout;
  return std::nullopt;
}

std::uint32_t atlas_bytes(std::uint32_t size) {
  AtlasShape shape{static_cast<std::uint32_t>(std::bit_width(size) - 1),
                   static_cast<std::uint32_t>(std::bit_width(size) - 1), 1};
  while (shape.levels < kMaxLevels && size >> (shape.levels - 1) > kMinSize) ++shape.levels;
  return sizeof(std::uint32_t) * shape.words();
}

EncodedAtlas encode_atlas(const AtlasLayout& layout, std::span<const ChartTexels> texels) {
  Level level{layout.width, layout.height, {}, {}};
  level.color.resize(std::size_t{level.width} * level.height);
  level.weight.resize(level.color.size());
  for (std::size_t c = 0; c < texels.size(); ++c) {
    if (!texels[c].painted || layout.rasters[c].size[0] == 0) continue;
    const auto& size = layout.rasters[c].size;
    for (std::uint32_t y = 0; y < size[1]; ++y)
      for (std::uint32_t x = 0; x < size[0]; ++x) {
        const std::size_t at = std::size_t{layout.place[c][1] + y} * level.width + layout.place[c][0] + x;
        level.color[at] = texels[c].colors[std::size_t{y} * size[0] + x];
        level.weight[at] = 1;
      }
  }
  EncodedAtlas atlas;
  std::uint32_t levels = 0;
  for (;;) {
    append_blocks(level, atlas.blocks);
    if (++levels == kMaxLevels || std::min(level.width, level.height) <= kMinSize) break;
    level = halved(level);
  }
  atlas.size = AtlasShape{static_cast<std::uint32_t>(std::bit_width(layout.width) - 1),
                          static_cast<std::uint32_t>(std::bit_width(layout.height) - 1), levels}
                   .pack();
  return atlas;
}

}  // namespace zc
