// SPDX-License-Identifier: Apache-2.0
#include "replay/compare.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>

#include "base/file.h"
#include "replay/flip.h"
#include "replay/render_setup.h"
#include "replay/zone_table.h"
#include "streamer/index_file.h"

namespace zc {
namespace {

constexpr std::uint32_t kTileWidth = 400;
// The source, then from the finest proxies to what a replay shows at coarser tolerances.
struct Level {
  const char* name;
  double tolerance;
  bool detail;
};
constexpr double kNone = 1e-9;  // refines everything
constexpr std::array<Level, 5> kLevels = {{{"source", kNone, true},
                                           {"finest", kNone, false},
                                           {"tolerance_0.002", 0.002, false},
                                           {"tolerance_0.01", 0.01, false},
                                           {"tolerance_0.05", 0.05, false}}};

// One level of a world, drawn as the host draws its scene.
class LevelView {
 public:
  static Result<std::unique_ptr<LevelView>> open(Device& device, Source& source, const CompareOptions& options,
                                                 const Level& level) {
    auto view = std::make_unique<LevelView>();
    ZC_ASSIGN(const WorldIndex index, read_world_index(source, options.world));
    const auto max_zones = static_cast<std::uint32_t>(index.nodes.size());
    view->zones_.emplace(device);
    view->sink_.emplace(*view->zones_, max_zones);
    StreamerOptions paging;
    paging.cap_bytes = options.budget_bytes;
    paging.pool_limit_bytes = std::min<std::uint64_t>(paging.pool_limit_bytes, device.limits().maxStorageBufferRange);
    paging.threads = options.threads;
    paging.tolerance = level.tolerance;
    paging.include_detail = level.detail;
    paging.settle = true;
    ZC_ASSIGN(view->streamer_, Streamer::open(source, paging, *view->sink_));
    view->table_.emplace(*view->streamer_, *view->zones_, level.tolerance);
    RendererOptions renderer = options.renderer;
    renderer.reflections = ReflectionMode::kNone;
    set_sun(renderer, index, options.sun);
    renderer.page_depth = deepest_page(index);
    renderer.max_zones = max_zones;
    ZC_ASSIGN(view->renderer_,
              Renderer::create(device, *view->zones_, *view->zones_, material_entries(index), renderer));
    return view;
  }

  // triangles: of what was drawn, added to.
  Result<Picture> draw(const CameraSample& sample, double time_s, const RendererOptions& options,
                       std::uint64_t& triangles) {
    ZC_ASSIGN(const RenderCamera camera, make_camera(streamer_->index(), sample));
    const View view{sample.eye};
    ZC_TRY(streamer_->advance(std::span(&view, 1), time_s));
    ZC_TRY(table_->update(view));
    const std::vector<ZoneDraw> draws =
        table_->draws(camera, static_cast<double>(options.width) / options.height, true);
    for (const ZoneDraw& draw : draws) triangles += draw.triangle_count;
    ZC_ASSIGN([[maybe_unused]] const FrameResult drawn, renderer_->render(camera, draws));
    return picture_of(*renderer_, options);
  }

 private:
  std::optional<ZoneSet> zones_;
  std::optional<GpuPageSink> sink_;
  std::unique_ptr<Streamer> streamer_;
  std::optional<ZoneTable> table_;
  std::unique_ptr<Renderer> renderer_;
};

std::string frame_name(const CameraSample& sample, std::uint64_t frame) {
  if (!sample.name.empty()) return sample.name;
  const std::string number = std::to_string(frame);
  return std::string(number.size() < 6 ? 6 - number.size() : 0, '0') + number;
}

std::string compare_json(const CompareReport& report) {
  nlohmann::ordered_json json;
  json["device"] = report.device;
  json["frames"] = report.frames;
  json["levels"] = nlohmann::ordered_json::array();
  for (const ComparedLevel& level : report.levels)
    json["levels"].push_back({{"name", level.name},
                              {"tolerance", level.tolerance},
                              {"mean_flip", level.mean_flip},
                              {"max_flip", *std::ranges::max_element(level.flip)},
                              {"triangles_per_frame", level.triangles / report.frames.size()},
                              {"flip", level.flip}});
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace

Result<CompareReport> run_compare(const CompareOptions& options) {
  if (options.frames.begin >= options.path.size())
    return Error{ErrorCode::kArgument,
                 "--frames begins behind the path's " + std::to_string(options.path.size()) + " frames"};
  ZC_ASSIGN(const std::unique_ptr<Source> source, open_source(options.world, options.source));
  ZC_ASSIGN(const std::unique_ptr<Device> device, Device::create({options.device, false}));
  CompareReport report;
  report.device = device->name();
  for (const Level& level : kLevels) {
    ZC_TRY(make_folder(options.out / level.name));
    if (!level.detail) ZC_TRY(make_folder(options.out / (std::string(level.name) + "_flip")));
  }
  const std::uint64_t end = std::min<std::uint64_t>(options.frames.end, options.path.size());
  std::vector<std::uint64_t> frames;
  for (std::uint64_t frame = options.frames.begin; frame < end; frame += options.frames.step) frames.push_back(frame);
  for (const std::uint64_t frame : frames) report.frames.push_back(frame_name(options.path[frame], frame));

  // Level by level, so that one at a time takes memory.
  const std::uint32_t width = options.renderer.width;
  const std::uint32_t height = options.renderer.height;
  std::vector<Picture> reference;
  std::vector<std::vector<Picture>> shown;  // small, by level
  std::vector<std::vector<Picture>> maps;
  for (std::size_t l = 0; l < kLevels.size(); ++l) {
    const Level& level = kLevels[l];
    ZC_ASSIGN(const std::unique_ptr<LevelView> view, LevelView::open(*device, *source, options, level));
    ComparedLevel row{level.name, level.detail ? 0 : level.tolerance, {}};
    shown.emplace_back();
    maps.emplace_back();
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const std::string file = report.frames[i] + ".png";
      ZC_ASSIGN(Picture picture,
                view->draw(options.path[frames[i]], static_cast<double>(i), options.renderer, row.triangles));
      ZC_TRY(write_png(options.out / level.name / file, picture));
      shown.back().push_back(scale_down(picture, std::min(kTileWidth, width)));
      if (level.detail) {
        maps.back().push_back(scale_down(flip_picture(std::vector<float>(std::size_t{width} * height), width, height),
                                         std::min(kTileWidth, width)));
        reference.push_back(std::move(picture));
      } else {
        const std::vector<float> map = flip_map(reference[i], picture);
        row.flip.push_back(mean_of_flip(map));
        const Picture heat = flip_picture(map, width, height);
        ZC_TRY(write_png(options.out / (std::string(level.name) + "_flip") / file, heat));
        maps.back().push_back(scale_down(heat, std::min(kTileWidth, width)));
      }
      if (options.progress)
        options.progress(
            static_cast<double>(l * frames.size() + i + 1) / static_cast<double>(kLevels.size() * frames.size()),
            level.name);
    }
    if (level.detail) continue;
    row.mean_flip = std::accumulate(row.flip.begin(), row.flip.end(), 0.0) / static_cast<double>(row.flip.size());
    report.levels.push_back(std::move(row));
  }
  std::vector<Picture> tiles;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    for (const auto& column : shown) tiles.push_back(column[i]);
    for (const auto& column : maps) tiles.push_back(column[i]);
  }
  ZC_TRY(write_png(options.out / "contact_sheet.png",
                   make_contact_sheet(tiles, static_cast<std::uint32_t>(kLevels.size()), tiles[0].width)));
  const std::string text = compare_json(report);
  ZC_TRY(write_file(options.out / "compare.json", std::as_bytes(std::span(text))));
  return report;
}

}  // namespace zc
