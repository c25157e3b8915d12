// SPDX-License-Identifier: Apache-2.0
// The contact sheet of `compare`: a row a frame, the source at its left, then a column a level with what it draws and,
// below, where that differs from the source; of few levels, several frames side by side. Titles, names, values and the
// meaning of the colours are drawn in. Thread-safe: no state.
#pragma once

#include <string>
#include <vector>

#include "replay/image/png_file.h"

namespace zc {

// What a sheet has room for, so that it can be looked at.
inline constexpr std::size_t kSheetRowLimit = 12;
inline constexpr std::size_t kSheetLevelLimit = 8;

struct SheetColumn {
  std::string title;
  std::vector<std::string> lines = {};  // below it
};

struct SheetCell {
  Picture picture;
  Picture difference = {};  // none at the source, in whose place the frame is described
  std::string caption = {};
};

struct SheetRow {
  std::string name;
  std::vector<std::string> lines;
  std::vector<SheetCell> cells;  // one a column, the source first; pictures of one size
};

struct CompareSheet {
  std::string title;
  std::vector<std::string> lines;
  std::vector<SheetColumn> columns;
  std::vector<SheetRow> rows;
};

// How wide pictures of this size go on it.
std::uint32_t sheet_tile_width(std::uint32_t width, std::uint32_t height);
Picture draw_compare_sheet(const CompareSheet& sheet);

}  // namespace zc
