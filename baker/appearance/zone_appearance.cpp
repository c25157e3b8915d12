// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/appearance/zone_appearance.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <map>
#include <utility>

#include "baker/appearance/atlas.h"
#include "baker/appearance/charts.h"

namespace zc {
namespace {

// Charts that vary less than this, in 8-bit sRGB, show nothing but their mean.
constexpr float kFlatDeviation = 2;
// How often the atlas is laid out anew without the charts that show nothing.
constexpr int kRounds = 2;
// Places of texels stay within 16 bits.
constexpr double kMaxTexelsPerStep = 0.45;

class AppearanceTable {
 public:
  explicit AppearanceTable(ZoneAppearance& out) : out_(out) {}

  // Nothing when the table is full.
  std::optional<std::uint16_t> add(const gpu::Appearance& appearance) {
    const auto [slot, is_new] = known_.try_emplace({appearance.material, appearance.place}, out_.appearances.size());
    if (is_new) {
      if (out_.appearances.size() == kZoneAppearancesMax) return std::nullopt;
      out_.appearances.push_back(appearance);
    }
    return static_cast<std::uint16_t>(slot->second);
  }

 private:
  ZoneAppearance& out_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> known_;
};

std::uint32_t srgb_word(const glm::vec3& c) {
  return linear_to_srgb8(c.r) | std::uint32_t{linear_to_srgb8(c.g)} << 8U | std::uint32_t{linear_to_srgb8(c.b)} << 16U;
}

// So that blocks spend their bits on what is there; returns by how much, as gpu::Appearance has it.
std::uint32_t brighten(std::span<glm::vec3> colors) {
  float most = 0;
  for (const glm::vec3& c : colors) most = std::max({most, c.r, c.g, c.b});
  if (!(most > 0)) return 0;
  const auto gain = static_cast<std::uint32_t>(std::clamp(std::floor(-32 * std::log2(most)), 0.0F, 255.0F));
  const float factor = std::exp2(static_cast<float>(gain) / 32);
  for (glm::vec3& c : colors) c *= factor;
  return gain;
}

class AppearanceMaker {
 public:
  AppearanceMaker(const ZoneMesh& mesh, const NodeRecord& node, const TextureSource& source,
                  std::span<const Material> materials, double step_m)
      : mesh_(mesh), node_(node), source_(source), materials_(materials) {
    frame_.origin = {node.origin[0], node.origin[1], node.origin[2]};
    frame_.steps = std::exp2(node.step_shift);
    zone_step_m_ = step_m * frame_.steps;
    // Whatever the surface was moved by, and its rounding.
    reach_ = 2 + 3 * static_cast<double>(std::max(node.error_max_m, 0.1F)) / zone_step_m_;
  }

  ZoneAppearance run(const AtlasOptions& options) {
    std::vector<bool> textured(mesh_.triangles.size());
    for (std::size_t t = 0; t < textured.size(); ++t) textured[t] = materials_[mesh_.materials[t]].texture.has_value();
    charts_ = cut_charts(mesh_, textured);
    if (charts_.empty()) return {};
    paint(options);
    return collect();
  }

 private:
  // Charts that turn out to be of one colour leave the atlas to the others, which may then be finer.
  void paint(const AtlasOptions& options) {
    texels_.resize(charts_.size());
    rasters_.resize(charts_.size());
    std::vector<std::uint32_t> chosen(charts_.size());
    for (std::uint32_t c = 0; c < chosen.size(); ++c) chosen[c] = c;
    find_sources();
    const double finest = std::min(options.texels_per_m * zone_step_m_, kMaxTexelsPerStep);
    for (int round = 0;; ++round) {
      const bool is_last = round == kRounds;
      std::vector<const Chart*> charts;
      charts.reserve(chosen.size());
      for (const std::uint32_t c : chosen) charts.push_back(&charts_[c]);
      layout_ = charts.empty() ? std::nullopt : lay_out_atlas(charts, finest, options.max_size);
      std::vector<std::uint32_t> pictures;
      for (std::size_t i = 0; i < chosen.size(); ++i) {
        const Chart& chart = charts_[chosen[i]];
        // What has no place is painted coarsely, for its mean.
        const bool has_place = layout_ && layout_->rasters[i].size[0] > 0;
        const ChartRaster raster = has_place ? layout_->rasters[i] : coarse_raster(chart);
        ChartTexels& texels = texels_[chosen[i]];
        if (round == 0 || raster != rasters_[chosen[i]])
          texels = resample(mesh_, chart, raster, frame_, sources_of(chart), source_, materials_, reach_);
        rasters_[chosen[i]] = raster;
        if (has_place && (is_last || (texels.painted && texels.deviation >= kFlatDeviation)))
          pictures.push_back(chosen[i]);
        else
          texels.colors = {};
      }
      const bool settled = is_last || pictures.size() == chosen.size();
      if (settled && layout_) keep_places(chosen, pictures);
      chosen = std::move(pictures);
      if (settled || !layout_) break;
    }
    if (chosen.empty()) layout_ = std::nullopt;
    in_atlas_ = std::move(chosen);
  }

  // The layout of `before` without those that are not in `after`.
  void keep_places(const std::vector<std::uint32_t>& before, const std::vector<std::uint32_t>& after) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < before.size() && kept < after.size(); ++i) {
      if (before[i] != after[kept]) continue;
      layout_->rasters[kept] = layout_->rasters[i];
      layout_->place[kept++] = layout_->place[i];
    }
    layout_->rasters.resize(kept);
    layout_->place.resize(kept);
  }

  static ChartRaster coarse_raster(const Chart& chart) {
    const auto longest = std::max({chart.max[0] - chart.min[0], chart.max[1] - chart.min[1], 1});
    ChartRaster raster;
    raster.texels_per_step = 16.0 / longest;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      raster.first[axis] = static_cast<std::int32_t>(std::floor(chart.min[axis] * raster.texels_per_step));
      raster.size[axis] = 18;
    }
    return raster;
  }

  void find_sources() {
    const glm::dvec3 margin(reach_ * frame_.steps);
    nearby_ = source_.within(glm::dvec3(node_.bounds_min[0], node_.bounds_min[1], node_.bounds_min[2]) - margin,
                             glm::dvec3(node_.bounds_max[0], node_.bounds_max[1], node_.bounds_max[2]) + margin);
  }

  [[nodiscard]] std::vector<const SourceTriangle*> sources_of(const Chart& chart) const {
    glm::dvec3 low(1e300);
    glm::dvec3 high(-1e300);
    for (const std::uint32_t t : chart.triangles)
      for (const std::uint32_t v : mesh_.triangles[t]) {
        const glm::dvec3 q(mesh_.vertices[v][0], mesh_.vertices[v][1], mesh_.vertices[v][2]);
        low = glm::min(low, q);
        high = glm::max(high, q);
      }
    low = frame_.origin + (low - reach_) * frame_.steps;
    high = frame_.origin + (high + reach_) * frame_.steps;
    std::vector<const SourceTriangle*> found;
    for (const SourceTriangle* s : nearby_) {
      const glm::dvec3 min = glm::min(glm::min(s->p[0], s->p[1]), s->p[2]);
      const glm::dvec3 max = glm::max(glm::max(s->p[0], s->p[1]), s->p[2]);
      if (min.x <= high.x && min.y <= high.y && min.z <= high.z && max.x >= low.x && max.y >= low.y && max.z >= low.z)
        found.push_back(s);
    }
    return found;
  }

  ZoneAppearance collect() {
    ZoneAppearance out;
    AppearanceTable table(out);
    out.appearance_of.resize(mesh_.triangles.size());
    for (std::size_t t = 0; t < out.appearance_of.size(); ++t)
      if (const auto appearance = table.add({mesh_.materials[t], 0})) out.appearance_of[t] = *appearance;
    const auto set = [&](const Chart& chart, std::uint32_t bits, std::uint32_t place) {
      for (const std::uint32_t t : chart.triangles)
        if (const auto appearance = table.add({mesh_.materials[t] | bits, place})) out.appearance_of[t] = *appearance;
    };
    std::vector<bool> pictured(charts_.size());
    for (std::size_t i = 0; i < in_atlas_.size(); ++i) {
      const Chart& chart = charts_[in_atlas_[i]];
      if (!texels_[in_atlas_[i]].painted) continue;
      pictured[in_atlas_[i]] = true;
      std::array<std::uint32_t, 2> moved{};
      for (std::size_t axis = 0; axis < 2; ++axis)
        moved[axis] = static_cast<std::uint32_t>(static_cast<std::int32_t>(layout_->place[i][axis]) -
                                                 layout_->rasters[i].first[axis]);
      const std::uint32_t gain = brighten(texels_[in_atlas_[i]].colors);
      set(chart, gpu::kAppearanceTextured << 16U | chart.axis << 18U | gain << 23U,
          (moved[0] & 0xFFFFU) | moved[1] << 16U);
    }
    for (std::size_t c = 0; c < charts_.size(); ++c)
      if (!pictured[c] && texels_[c].painted) {
        const std::uint32_t gain = brighten({&texels_[c].mean, 1});
        set(charts_[c], gpu::kAppearanceColor << 16U | gain << 23U, srgb_word(texels_[c].mean));
      }
    if (layout_) {
      std::vector<ChartTexels> texels;
      for (const std::uint32_t c : in_atlas_) texels.push_back(std::move(texels_[c]));
      EncodedAtlas atlas = encode_atlas(*layout_, texels);
      out.atlas_size = atlas.size;
      out.texels_per_step = static_cast<float>(layout_->texels_per_step);
      out.atlas = std::move(atlas.blocks);
    }
    return out;
  }

  const ZoneMesh& mesh_;
  const NodeRecord& node_;
  const TextureSource& source_;
  std::span<const Material> materials_;
  ZoneFrame frame_;
  double zone_step_m_ = 0;
  double reach_ = 0;  // zone steps
  std::vector<const SourceTriangle*> nearby_;
  std::vector<Chart> charts_;
  std::vector<ChartTexels> texels_;      // of each chart; no colours for those of one colour
  std::vector<ChartRaster> rasters_;     // that they were painted for
  std::vector<std::uint32_t> in_atlas_;  // charts, in the order of layout_
  std::optional<AtlasLayout> layout_;
};

}  // namespace

ZoneAppearance make_zone_appearance(const ZoneMesh& mesh, const NodeRecord& node, const TextureSource& source,
                                    std::span<const Material> materials, double step_m, const AtlasOptions& options) {
  return AppearanceMaker(mesh, node, source, materials, step_m).run(options);
}

}  // namespace zc
