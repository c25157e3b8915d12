// SPDX-License-Identifier: Apache-2.0
#include "replay/compare/compare.h"

#include <algorithm>
#include <memory>
#include <numeric>

#include "replay/compare/compare_files.h"
#include "replay/compare/compare_frames.h"
#include "replay/compare/compare_levels.h"
#include "replay/compare/format_text.h"
#include "replay/compare/level_view.h"
#include "replay/compare/sheet_builder.h"
#include "replay/image/flip.h"
#include "streamer/open_source.h"
#include "streamer/source/index_file.h"

namespace zc {
namespace {

// Pictures of the full detail are in memory until every level was compared with them; so many bytes at a time.
constexpr std::uint64_t kReferenceBytes = 256ULL << 20U;

class Comparison {
 public:
  explicit Comparison(const CompareOptions& options) : options_(options) {}

  Result<CompareReport> run() {
    ZC_ASSIGN(source_, open_source(options_.world, options_.source));
    ZC_ASSIGN(const WorldIndex index, read_world_index(*source_, options_.world));
    ZC_ASSIGN(frames_, choose_frames(*source_, index, options_));
    ZC_ASSIGN(device_, Device::create({options_.device, false}));
    levels_ = levels_of(index, options_.tolerances);
    ZC_ASSIGN(const CompareFiles files, CompareFiles::create(options_.out));
    for (const CompareLevel& level : levels_) ZC_TRY(files.add_level(level.row.name, !level.is_source));
    SheetBuilder sheet(frames_, width(), height());
    const auto at_once = std::max<std::size_t>(1, kReferenceBytes / (std::uint64_t{4} * width() * height()));
    for (std::size_t first = 0; first < frames_.size(); first += at_once)
      ZC_TRY(compare_frames(first, std::min(first + at_once, frames_.size()), files, sheet));
    CompareReport report = make_report();
    ZC_TRY(files.write_sheet(draw_compare_sheet(sheet.finish(options_.world.lexically_normal().string(), levels_))));
    ZC_TRY(files.write_report(report));
    return report;
  }

 private:
  [[nodiscard]] std::uint32_t width() const { return options_.renderer.width; }
  [[nodiscard]] std::uint32_t height() const { return options_.renderer.height; }

  // Level by level, so that one at a time takes memory.
  Status compare_frames(std::size_t first, std::size_t last, const CompareFiles& files, SheetBuilder& sheet) {
    std::vector<Picture> references;
    for (CompareLevel& level : levels_) {
      show_progress(level);
      ZC_ASSIGN(const std::unique_ptr<LevelView> view, LevelView::open(*device_, *source_, options_, level));
      for (std::size_t i = first; i < last; ++i) {
        const CompareFrame& frame = frames_[i];
        ZC_ASSIGN(Picture picture, view->draw(frame.camera, static_cast<double>(i)));
        level.row.triangles += view->triangles();
        level.row.incomplete = level.row.incomplete || !view->complete();
        limited_by_device_ = limited_by_device_ || (!view->complete() && view->limited_by_device());
        ZC_TRY(files.write_picture(level.row.name, frame.name, picture));
        SheetCell cell{scale_down(picture, sheet.tile_width())};
        if (level.is_source) {
          references.push_back(std::move(picture));
        } else {
          const std::vector<float> map = flip_map(references[i - first], picture);
          level.row.flip.push_back(mean_of_flip(map));
          ZC_TRY(files.write_map(level.row.name, frame.name, flip_picture(map, width(), height(), width())));
          cell.difference = flip_picture(map, width(), height(), sheet.tile_width());
          cell.caption = format_text("FLIP %.4f", level.row.flip.back());
        }
        sheet.add(i, std::move(cell));
        ++pictures_done_;
        show_progress(level);
      }
    }
    return {};
  }

  void show_progress(const CompareLevel& level) const {
    const std::size_t all = levels_.size() * frames_.size();
    if (!options_.progress) return;
    options_.progress(static_cast<double>(pictures_done_) / static_cast<double>(all),
                      format_text("%s, picture %zu of %zu", level.row.name.c_str(), pictures_done_, all));
  }

  // Completes the levels' rows.
  CompareReport make_report() {
    CompareReport report;
    report.device = device_->name();
    report.limited_by_device = limited_by_device_;
    for (const CompareFrame& frame : frames_) {
      report.frames.push_back(frame.name);
      if (!frame.sees_world) ++report.blind_frames;
    }
    for (CompareLevel& level : levels_) {
      if (level.is_source) {
        report.source_complete = !level.row.incomplete;
        continue;
      }
      level.row.mean_flip = std::accumulate(level.row.flip.begin(), level.row.flip.end(), 0.0) /
                            static_cast<double>(level.row.flip.size());
      report.levels.push_back(level.row);
    }
    return report;
  }

  const CompareOptions& options_;
  std::unique_ptr<Source> source_;
  std::unique_ptr<Device> device_;
  std::vector<CompareFrame> frames_;
  std::vector<CompareLevel> levels_;
  std::size_t pictures_done_ = 0;
  bool limited_by_device_ = false;
};

}  // namespace

Result<CompareReport> run_compare(const CompareOptions& options) { return Comparison(options).run(); }

}  // namespace zc
