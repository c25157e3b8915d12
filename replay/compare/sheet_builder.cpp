// SPDX-License-Identifier: Apache-2.0
#include "replay/compare/sheet_builder.h"

#include <algorithm>
#include <utility>

#include "replay/compare/format_text.h"
#include "replay/paths/spread_evenly.h"

namespace zc {
namespace {

SheetRow row_of(const CompareFrame& frame) {
  const CameraSample& camera = frame.camera;
  SheetRow row;
  row.name = (camera.name.empty() ? "frame " : "view ") + frame.name;
  if (camera.name.empty()) row.name += format_text(", %.2f s", camera.time_s);
  row.lines = {format_text("eye %.0f, %.0f, %.1f", camera.eye.x, camera.eye.y, camera.eye.z)};
  return row;
}

SheetColumn column_of(const CompareLevel& level) {
  SheetColumn column = level.column;
  if (!level.is_source) column.lines.push_back(format_text("mean FLIP %.4f", level.row.mean_flip));
  if (level.row.incomplete) column.lines.emplace_back("far zones coarser: no room");
  return column;
}

}  // namespace

SheetBuilder::SheetBuilder(std::span<const CompareFrame> frames, std::uint32_t width, std::uint32_t height)
    : frames_(frames),
      tile_width_(sheet_tile_width(width, height)),
      places_(spread_evenly(frames.size(), kSheetRowLimit)) {
  for (const std::size_t place : places_) rows_.push_back(row_of(frames_[place]));
}

void SheetBuilder::add(std::size_t frame, SheetCell cell) {
  const auto place = std::ranges::find(places_, frame);
  if (place != places_.end()) rows_[static_cast<std::size_t>(place - places_.begin())].cells.push_back(std::move(cell));
}

CompareSheet SheetBuilder::finish(const std::string& title, std::span<const CompareLevel> levels) {
  CompareSheet sheet;
  sheet.title = title + ": proxies against the full detail";
  sheet.lines = {
      "Two rows are a frame: above, what a level of proxies draws; below it, where a person would see that "
      "it differs from the source.",
      "FLIP: 0 is no difference, 1 the largest there is; the value is the picture's mean. Colours go by its root, so "
      "that small differences show."};
  for (const CompareLevel& level : levels) sheet.columns.push_back(column_of(level));
  sheet.rows = std::move(rows_);
  return sheet;
}

}  // namespace zc
