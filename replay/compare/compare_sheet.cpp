// SPDX-License-Identifier: Apache-2.0
#include "replay/compare/compare_sheet.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"
#include "replay/image/drawing.h"
#include "replay/image/flip.h"

namespace zc {
namespace {

constexpr Rgb kPaper = {255, 255, 255};
constexpr Rgb kBand = {238, 241, 245};
constexpr Rgb kInk = {20, 24, 32};
constexpr Rgb kFaint = {96, 104, 116};
constexpr std::uint32_t kTile = 320;  // longer side
constexpr std::size_t kColumns = 9;   // that lie side by side: of few levels, several frames
constexpr int kNarrowest = 240;       // of a column, for its texts

// Where things lie. All of it follows from the size of the tiles and how many there are.
struct Layout {
  explicit Layout(const CompareSheet& sheet) {
    ZC_CHECK(!sheet.columns.empty() && !sheet.rows.empty());
    for (const SheetRow& row : sheet.rows) ZC_CHECK(row.cells.size() == sheet.columns.size());
    const Picture& tile = sheet.rows[0].cells[0].picture;
    tile_width = static_cast<int>(tile.width);
    tile_height = static_cast<int>(tile.height);
    cell_width = std::max(tile_width, kNarrowest);
    text = std::clamp(cell_width / 14, 14, 24);
    title = text * 3 / 2;
    line = text * 5 / 4;
    gap = text / 2;
    columns = sheet.columns.size();
    const std::size_t abreast = std::clamp<std::size_t>(kColumns / columns, 1, sheet.rows.size());
    rows = (sheet.rows.size() + abreast - 1) / abreast;
    blocks = (sheet.rows.size() + rows - 1) / rows;
    block_width = static_cast<int>(columns) * (cell_width + gap) + 3 * gap;
    width = static_cast<int>(blocks) * block_width;
    for (const SheetColumn& column : sheet.columns) heads = std::max(heads, static_cast<int>(column.lines.size()));
    top = 2 * gap + title + static_cast<int>(sheet.lines.size()) * line + gap;
    first_row = top + gap + (1 + heads) * line + gap;
    std::size_t row_lines = 0;
    for (const SheetRow& row : sheet.rows) row_lines = std::max(row_lines, row.lines.size());
    const int frame_text = (static_cast<int>(row_lines) + 1) * line + legend_height();
    row_height = tile_height + gap / 2 + std::max(tile_height + line, frame_text) + 2 * gap;
    height = first_row + static_cast<int>(rows) * row_height;
  }
  [[nodiscard]] int legend_height() const { return text + 2 * line + gap; }
  [[nodiscard]] int column_x(std::size_t block, std::size_t column) const {
    return gap + static_cast<int>(block) * block_width + static_cast<int>(column) * (cell_width + gap);
  }

  int tile_width = 0, tile_height = 0, cell_width = 0, text = 0, title = 0, line = 0, gap = 0, heads = 0;
  int top = 0, first_row = 0, row_height = 0, block_width = 0, width = 0, height = 0;
  std::size_t columns = 0, rows = 0, blocks = 0;  // blocks of rows side by side
};

// A bar of the colours, and what they stand for.
void draw_legend(Picture& out, const Layout& at, int x, int y) {
  const int width = at.cell_width;
  draw_text(out, x, y, fit_text("FLIP difference", at.text, width), at.text, kFaint);
  const int bar = y + at.line;
  for (int i = 0; i < width; ++i) {
    const float share = static_cast<float>(i) / static_cast<float>(std::max(1, width - 1));
    fill_rectangle(out, x + i, bar, 1, at.text, flip_color(share * share));
  }
  struct Tick {
    const char* text;
    float value;
  };
  int free = x;
  for (const auto& [text, value] :
       {Tick{"0", 0}, Tick{".05", 0.05F}, Tick{".2", 0.2F}, Tick{".5", 0.5F}, Tick{"1", 1}}) {
    const int label = text_width(text, at.text);
    const int middle = x + static_cast<int>(std::sqrt(value) * static_cast<float>(width - 1));
    const int left = std::clamp(middle - label / 2, x, x + width - label);
    if (left < free) continue;
    fill_rectangle(out, middle, bar + at.text, 1, at.text / 4, kInk);
    draw_text(out, left, bar + at.text + at.text / 5, text, at.text, kFaint);
    free = left + label + at.text / 3;
  }
}

void draw_head(Picture& out, const Layout& at, const SheetColumn& column, int x) {
  int y = at.top + at.gap / 2;
  draw_text(out, x, y, fit_text(column.title, at.text, at.cell_width), at.text, kInk);
  for (const std::string& text : column.lines) {
    y += at.line;
    draw_text(out, x, y, fit_text(text, at.text, at.cell_width), at.text, kFaint);
  }
}

void draw_row(Picture& out, const Layout& at, const SheetRow& row, std::size_t block, int y) {
  const int below = y + at.tile_height + at.gap / 2;
  for (std::size_t c = 0; c < row.cells.size(); ++c) {
    const SheetCell& cell = row.cells[c];
    const int x = at.column_x(block, c);
    paste(out, cell.picture, x, y);
    paste(out, cell.difference, x, below);
    draw_text(out, x, below + at.tile_height + at.gap / 4, fit_text(cell.caption, at.text, at.cell_width), at.text,
              kInk);
  }
  const int x = at.column_x(block, 0);
  int text_y = below;
  draw_text(out, x, text_y, fit_text(row.name, at.text, at.cell_width), at.text, kInk);
  for (const std::string& line : row.lines) {
    text_y += at.line;
    draw_text(out, x, text_y, fit_text(line, at.text, at.cell_width), at.text, kFaint);
  }
  draw_legend(out, at, x, text_y + at.line + at.gap);
}

}  // namespace

std::uint32_t sheet_tile_width(std::uint32_t width, std::uint32_t height) {
  return std::min(width, std::max(1U, kTile * width / std::max(width, height)));
}

Picture draw_compare_sheet(const CompareSheet& sheet) {
  const Layout at(sheet);
  Picture out = blank_picture(static_cast<std::uint32_t>(at.width), static_cast<std::uint32_t>(at.height), kPaper);
  const int room = at.width - 2 * at.gap;
  draw_text(out, at.gap, at.gap, fit_text(sheet.title, at.title, room), at.title, kInk);
  int y = 2 * at.gap + at.title;
  for (const std::string& line : sheet.lines) {
    draw_text(out, at.gap, y, fit_text(line, at.text, room), at.text, kFaint);
    y += at.line;
  }
  fill_rectangle(out, 0, at.top, at.width, at.first_row - at.top - at.gap, kBand);
  for (std::size_t block = 0; block < at.blocks; ++block)
    for (std::size_t c = 0; c < at.columns; ++c) draw_head(out, at, sheet.columns[c], at.column_x(block, c));
  for (std::size_t r = 0; r < sheet.rows.size(); ++r)
    draw_row(out, at, sheet.rows[r], r / at.rows, at.first_row + static_cast<int>(r % at.rows) * at.row_height);
  return out;
}

}  // namespace zc
