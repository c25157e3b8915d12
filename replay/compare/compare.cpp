// SPDX-License-Identifier: Apache-2.0
#include "replay/compare/compare.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>

#include "base/file.h"
#include "replay/compare/compare_sheet.h"
#include "replay/compare/level_source.h"
#include "replay/host/zone_draws.h"
#include "replay/image/flip.h"
#include "replay/session/render_setup.h"
#include "replay/session/world_tour.h"
#include "runtime/scene/zone_set.h"
#include "streamer/open_source.h"
#include "streamer/source/index_file.h"
#include "streamer/streamer.h"

namespace zc {
namespace {

constexpr double kRefineAll = 1e-9;  // tolerance
constexpr std::size_t kFrames = 8;
// Pictures of the full detail are in memory until every level was held against them; so many bytes at a time.
constexpr std::uint64_t kReferenceBytes = 256ULL << 20U;

struct Level {
  ComparedLevel row;
  double tolerance = kRefineAll;
  bool detail = false;
  std::optional<WorldIndex> cut;  // of a stored level: the world down to its depth
  SheetColumn column;
};

template <class... Values>
std::string text_of(const char* format, Values... values) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

// "12,345"
std::string with_commas(std::uint64_t value) {
  std::string text = std::to_string(value);
  for (std::size_t at = text.size(); at > 3;) text.insert(at -= 3, 1, ',');
  return text;
}

// A bound: rounded up.
std::string metres(double value) {
  const double parts = value < 1 ? 100 : value < 10 ? 10 : 1;
  return text_of(value < 1 ? "%.2f m" : value < 10 ? "%.1f m" : "%.0f m", std::ceil(value * parts) / parts);
}

// `most` of so many, the first and the last among them.
std::vector<std::size_t> spread_evenly(std::size_t count, std::size_t most) {
  std::vector<std::size_t> out;
  const std::size_t chosen = std::min(count, most);
  for (std::size_t i = 0; i < chosen; ++i) out.push_back(chosen == 1 ? 0 : i * (count - 1) / (chosen - 1));
  return out;
}

Level stored_level(const WorldIndex& index, std::uint32_t depth, bool finest) {
  Level level;
  level.row.name = finest ? "finest" : "level_" + std::to_string(depth);
  level.row.depth = depth;
  level.cut = cut_at_depth(index, depth);
  std::uint64_t triangles = 0;
  for (const NodeRecord& node : level.cut->nodes) {
    if (node.child_count > 0) continue;
    triangles += node.triangle_count;
    level.row.error_max_m = std::max(level.row.error_max_m, static_cast<double>(node.error_max_m));
  }
  level.column.title = finest ? text_of("finest proxies (level %u)", depth)
                              : text_of(depth == 0 ? "level %u, the coarsest" : "level %u", depth);
  level.column.lines = {"within " + metres(level.row.error_max_m) + " of the source",
                        with_commas(triangles) + " triangles"};
  return level;
}

std::vector<Level> levels_of(const WorldIndex& index, const std::vector<double>& tolerances) {
  std::vector<Level> levels(1);
  levels[0].row.name = "source";
  levels[0].detail = true;
  levels[0].column = {"source", {"the full detail", with_commas(index.header.source_triangles) + " triangles"}};
  std::set<std::uint32_t, std::greater<>> stored;
  for (const NodeRecord& node : index.nodes)
    if (!node.is_detail()) stored.insert(node.depth);
  const std::vector<std::uint32_t> depths(stored.begin(), stored.end());
  for (const std::size_t i : spread_evenly(depths.size(), kSheetLevelsMost))
    levels.push_back(stored_level(index, depths[i], i == 0));
  for (const double tolerance : tolerances) {
    Level level;
    level.row.name = "tolerance_" + text_of("%g", tolerance);
    level.row.tolerance = level.tolerance = tolerance;
    level.column = {"what a replay pages", {text_of("--tolerance %g:", tolerance), "finer where it is near"}};
    levels.push_back(std::move(level));
  }
  return levels;
}

// One level of a world, drawn as the host draws its scene.
class LevelView {
 public:
  static Result<std::unique_ptr<LevelView>> open(Device& device, Source& whole, const WorldIndex& index,
                                                 const CompareOptions& options, const Level& level) {
    auto view = std::make_unique<LevelView>();
    if (level.cut) view->cut_.emplace(whole, *level.cut);
    Source& source = level.cut ? *view->cut_ : whole;
    view->zones_.emplace(device);
    StreamerOptions paging;
    paging.cap_bytes = options.budget_bytes;
    paging.threads = options.threads;
    paging.tolerance = level.tolerance;
    paging.include_detail = level.detail;
    paging.settle = true;
    ZC_ASSIGN(view->streamer_, Streamer::open(source, paging, *view->zones_));
    HostOptions renderer = options.renderer;
    renderer.reflections = ReflectionMode::kNone;
    set_sun(renderer, index, options.sun);
    renderer.page_depth = deepest_page(index);
    ZC_ASSIGN(view->renderer_,
              StandInHost::create(device, *view->zones_, *view->zones_, material_entries(index), renderer));
    return view;
  }

  // triangles: of what was drawn, added to.
  Result<Picture> draw(const CameraSample& sample, double time_s, const HostOptions& options,
                       std::uint64_t& triangles) {
    ZC_ASSIGN(const FrameCamera camera, make_camera(streamer_->index(), sample));
    const View view{sample.eye};
    ZC_TRY(streamer_->advance(std::span(&view, 1), time_s));
    const std::vector<ZoneDraw> draws =
        zone_draws(*zones_, streamer_->index(), camera, static_cast<double>(options.width) / options.height, true);
    for (const ZoneDraw& draw : draws) triangles += draw.triangle_count;
    ZC_ASSIGN([[maybe_unused]] const FrameResult drawn, renderer_->render(camera, draws));
    return picture_of(*renderer_, options);
  }

  [[nodiscard]] bool limited_by_device() const { return streamer_->statistics().pool_limited_by_sink; }
  // Of the frame drawn last.
  [[nodiscard]] bool complete() const { return streamer_->statistics().frame.missing_nodes == 0; }

 private:
  std::optional<LevelSource> cut_;
  std::optional<ZoneSet> zones_;
  std::unique_ptr<Streamer> streamer_;
  std::unique_ptr<StandInHost> renderer_;
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
  json["blind_frames"] = report.blind_frames;
  json["source_complete"] = report.source_complete;
  json["pool_limited_by_device"] = report.limited_by_device;
  json["levels"] = nlohmann::ordered_json::array();
  for (const ComparedLevel& level : report.levels) {
    nlohmann::ordered_json row = {{"name", level.name}};
    if (level.depth) row.update({{"depth", *level.depth}, {"error_m_max", level.error_max_m}});
    if (level.tolerance) row["tolerance"] = *level.tolerance;
    row.update({{"mean_flip", level.mean_flip},
                {"max_flip", *std::ranges::max_element(level.flip)},
                {"triangles_per_frame", level.triangles / report.frames.size()},
                {"complete", !level.incomplete},
                {"flip", level.flip}});
    json["levels"].push_back(std::move(row));
  }
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

// Only what this command writes.
Status remove_earlier_pictures(const std::filesystem::path& out) {
  std::error_code code;
  std::vector<std::filesystem::path> folders;
  for (std::filesystem::directory_iterator at(out, code); !code && at != std::filesystem::directory_iterator();
       at.increment(code)) {
    const std::string name = at->path().filename().string();
    if (name == "source" || name == "finest" || name == "finest_flip" || name.starts_with("level_") ||
        name.starts_with("tolerance_"))
      folders.push_back(at->path());
  }
  for (const std::filesystem::path& folder : folders) ZC_TRY(remove_written_pngs(folder));
  return remove_written_png(out / "contact_sheet.png");
}

class Comparison {
 public:
  explicit Comparison(const CompareOptions& options) : options_(options) {}

  Result<CompareReport> run() {
    ZC_ASSIGN(source_, open_source(options_.world, options_.source));
    ZC_ASSIGN(index_, read_world_index(*source_, options_.world));
    ZC_TRY(choose_frames());
    ZC_ASSIGN(device_, Device::create({options_.device, false}));
    report_.device = device_->name();
    levels_ = levels_of(index_, options_.tolerances);
    tile_width_ = sheet_tile_width(width(), height());
    ZC_TRY(make_folder(options_.out));
    ZC_TRY(remove_earlier_pictures(options_.out));
    for (const Level& level : levels_) {
      ZC_TRY(make_folder(options_.out / level.row.name));
      if (!level.detail) ZC_TRY(make_folder(options_.out / (level.row.name + "_flip")));
    }
    const auto at_once = std::max<std::size_t>(1, kReferenceBytes / (std::uint64_t{4} * width() * height()));
    for (std::size_t first = 0; first < frames_.size(); first += at_once)
      ZC_TRY(compare_frames(first, std::min(first + at_once, frames_.size())));
    return finish();
  }

 private:
  [[nodiscard]] std::uint32_t width() const { return options_.renderer.width; }
  [[nodiscard]] std::uint32_t height() const { return options_.renderer.height; }

  // Fails where none of them looks at the world.
  Status choose_frames() {
    path_ = options_.path;
    if (path_.empty()) {
      ZC_ASSIGN(path_, tour_of(*source_, index_));
    }
    if (options_.frames) {
      if (options_.frames->begin >= path_.size())
        return Error{ErrorCode::kArgument,
                     "--frames begins behind the path's " + std::to_string(path_.size()) + " frames"};
      const std::uint64_t end = std::min<std::uint64_t>(options_.frames->end, path_.size());
      for (std::uint64_t frame = options_.frames->begin; frame < end; frame += options_.frames->step)
        frames_.push_back(frame);
    } else {
      for (const std::size_t frame : spread_evenly(path_.size(), kFrames)) frames_.push_back(frame);
    }
    for (const std::uint64_t frame : frames_) {
      const double aspect = static_cast<double>(width()) / height();
      ZC_ASSIGN(const bool appearances, looks_at_world(index_, path_[frame], aspect));
      if (!appearances) ++report_.blind_frames;
      report_.frames.push_back(frame_name(path_[frame], frame));
    }
    if (report_.blind_frames < frames_.size()) return {};
    return nothing_seen(index_, path_[frames_[0]]);
  }

  // Level by level, so that one at a time takes memory.
  Status compare_frames(std::size_t first, std::size_t last) {
    std::vector<Picture> references;
    for (Level& level : levels_) {
      show_progress(level);
      ZC_ASSIGN(const std::unique_ptr<LevelView> view, LevelView::open(*device_, *source_, index_, options_, level));
      for (std::size_t i = first; i < last; ++i) {
        const std::string file = report_.frames[i] + ".png";
        ZC_ASSIGN(Picture picture,
                  view->draw(path_[frames_[i]], static_cast<double>(i), options_.renderer, level.row.triangles));
        level.row.incomplete = level.row.incomplete || !view->complete();
        report_.limited_by_device = report_.limited_by_device || (!view->complete() && view->limited_by_device());
        ZC_TRY(write_png(options_.out / level.row.name / file, picture));
        SheetCell cell{scale_down(picture, tile_width_)};
        if (level.detail) {
          references.push_back(std::move(picture));
        } else {
          const std::vector<float> map = flip_map(references[i - first], picture);
          level.row.flip.push_back(mean_of_flip(map));
          ZC_TRY(write_png(options_.out / (level.row.name + "_flip") / file,
                           flip_picture(map, width(), height(), width())));
          cell.difference = flip_picture(map, width(), height(), tile_width_);
          cell.caption = text_of("FLIP %.4f", level.row.flip.back());
        }
        add_to_sheet(i, std::move(cell));
        ++done_;
        show_progress(level);
      }
    }
    return {};
  }

  void show_progress(const Level& level) const {
    const std::size_t all = levels_.size() * frames_.size();
    if (!options_.progress) return;
    options_.progress(static_cast<double>(done_) / static_cast<double>(all),
                      text_of("%s, picture %zu of %zu", level.row.name.c_str(), done_, all));
  }

  void add_to_sheet(std::size_t i, SheetCell cell) {
    const auto rows = spread_evenly(frames_.size(), kSheetRowsMost);
    const auto row = std::ranges::find(rows, i);
    if (row == rows.end()) return;
    sheet_.rows.resize(rows.size());
    sheet_.rows[static_cast<std::size_t>(row - rows.begin())].cells.push_back(std::move(cell));
  }

  Result<CompareReport> finish() {
    sheet_.title = options_.world.lexically_normal().string() + ": proxies against the full detail";
    sheet_.lines = {
        "Two rows are a frame: above, what a level of proxies draws; below it, where a person would see that "
        "it differs from the source.",
        "FLIP: 0 is no difference, 1 the largest there is; the value is the picture's mean. Colours go by its root, so "
        "that small differences show."};
    const auto rows = spread_evenly(frames_.size(), kSheetRowsMost);
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const CameraSample& sample = path_[frames_[rows[r]]];
      SheetRow& row = sheet_.rows[r];
      row.name = (sample.name.empty() ? "frame " : "view ") + report_.frames[rows[r]];
      row.lines = {text_of("eye %.0f, %.0f, %.1f", sample.eye.x, sample.eye.y, sample.eye.z)};
      if (sample.name.empty()) row.name += text_of(", %.2f s", sample.time_s);
    }
    for (Level& level : levels_) {
      if (!level.detail) {
        level.row.mean_flip =
            std::accumulate(level.row.flip.begin(), level.row.flip.end(), 0.0) / static_cast<double>(frames_.size());
        level.column.lines.push_back(text_of("mean FLIP %.4f", level.row.mean_flip));
        report_.levels.push_back(level.row);
      } else {
        report_.source_complete = !level.row.incomplete;
      }
      if (level.row.incomplete)
        level.column.lines.emplace_back(report_.limited_by_device ? "far zones coarser: the device"
                                                                  : "far zones coarser: --budget");
      sheet_.columns.push_back(level.column);
    }
    ZC_TRY(write_png(options_.out / "contact_sheet.png", draw_compare_sheet(sheet_)));
    const std::string text = compare_json(report_);
    ZC_TRY(write_file(options_.out / "compare.json", std::as_bytes(std::span(text))));
    return std::move(report_);
  }

  const CompareOptions& options_;
  CompareReport report_;
  CompareSheet sheet_;
  CameraPath path_;
  std::vector<std::uint64_t> frames_;
  std::unique_ptr<Source> source_;
  WorldIndex index_;
  std::unique_ptr<Device> device_;
  std::vector<Level> levels_;
  std::uint32_t tile_width_ = 0;
  std::size_t done_ = 0;  // pictures
};

}  // namespace

Result<CompareReport> run_compare(const CompareOptions& options) { return Comparison(options).run(); }

}  // namespace zc
