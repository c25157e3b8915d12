// SPDX-License-Identifier: Apache-2.0
// Fills the contact sheet of `compare` while its pictures are drawn, level by level.
// Borrows the frames. Threads: one.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "replay/compare/compare_frames.h"
#include "replay/compare/compare_levels.h"
#include "replay/compare/compare_sheet.h"

namespace zc {

class SheetBuilder {
 public:
  // width, height: of the pictures.
  SheetBuilder(std::span<const CompareFrame> frames, std::uint32_t width, std::uint32_t height);

  [[nodiscard]] std::uint32_t tile_width() const { return tile_width_; }
  // A frame's next level, where the frame is on the sheet.
  void add(std::size_t frame, SheetCell cell);
  // title: of the world. All cells are there.
  CompareSheet finish(const std::string& title, std::span<const CompareLevel> levels);

 private:
  std::span<const CompareFrame> frames_;
  std::uint32_t tile_width_;
  std::vector<std::size_t> places_;  // of the frames on the sheet
  std::vector<SheetRow> rows_;       // one a place
};

}  // namespace zc
