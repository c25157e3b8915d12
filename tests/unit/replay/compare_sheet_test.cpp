// SPDX-License-Identifier: Apache-2.0
#include "replay/compare/compare_sheet.h"

#include <gtest/gtest.h>

#include "replay/image/drawing.h"
#include "replay/image/flip.h"

namespace zc {
namespace {

constexpr Rgb kWhite = {255, 255, 255};
constexpr Rgb kBlack = {0, 0, 0};

struct Box {
  int x, y, width, height;
};

Rgb pixel(const Picture& picture, std::uint32_t x, std::uint32_t y) {
  const std::uint8_t* at = picture.rgba.data() + (std::size_t{y} * picture.width + x) * 4;
  return {at[0], at[1], at[2]};
}

// Of a colour, within a box.
int count(const Picture& picture, const Box& box, Rgb color) {
  int found = 0;
  for (int y = box.y; y < box.y + box.height; ++y)
    for (int x = box.x; x < box.x + box.width; ++x)
      found += pixel(picture, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)) == color ? 1 : 0;
  return found;
}

int all_of(const Picture& picture, Rgb color) {
  return count(picture, {0, 0, static_cast<int>(picture.width), static_cast<int>(picture.height)}, color);
}

TEST(Drawing, TextStaysInTheLineThatItAsksFor) {
  for (const char* text : {"source", "FLIP 0.0123", "|Ëgj|", "≤ 2 m … ü"}) {
    Picture picture = blank_picture(300, 60, kWhite);
    draw_text(picture, 20, 10, text, 24, kBlack);
    const Box line = {20, 10, text_width(text, 24), 24};
    EXPECT_GT(count(picture, line, kBlack), 20) << text;
    fill_rectangle(picture, line.x - 1, line.y, line.width + 2, line.height, kWhite);
    EXPECT_EQ(all_of(picture, kWhite), 300 * 60) << text;
  }
}

TEST(Drawing, DifferentTextsLookDifferentAndTheSameAlike) {
  const auto drawn = [](const char* text) {
    Picture picture = blank_picture(80, 30, kWhite);
    draw_text(picture, 2, 2, text, 20, kBlack);
    return picture.rgba;
  };
  EXPECT_EQ(drawn("0.0123"), drawn("0.0123"));
  EXPECT_NE(drawn("0.0123"), drawn("0.0124"));
  EXPECT_NE(drawn("é"), drawn("e"));
}

TEST(Drawing, WhatIsOutsideIsCutOffAndBytesThatAreNoTextAreMarked) {
  Picture picture = blank_picture(20, 20, kWhite);
  for (const int at : {-1000, -10, 15, 1000}) {
    draw_text(picture, at, at, "text", 20, kBlack);
    fill_rectangle(picture, at, at, 8, 8, kBlack);
    paste(picture, blank_picture(8, 8, kBlack), at, at);
  }
  EXPECT_EQ(pixel(picture, 15, 15), kBlack);
  EXPECT_EQ(pixel(picture, 8, 8), kWhite);
  const std::string marked = "a\xEF\xBF\xBD";
  for (const char* bad : {"a\xC3", "a\xFF", "a\n", "a\x80"}) {
    EXPECT_EQ(text_width(bad, 20), text_width(marked, 20));
    EXPECT_GT(text_width(bad, 20), text_width("a", 20));
  }
}

TEST(Drawing, LongTextsEndInAnEllipsisThatFits) {
  EXPECT_EQ(fit_text("short", 20, 500), "short");
  const std::string fitted = fit_text("a very long name of a wörld", 20, 150);
  EXPECT_LE(text_width(fitted, 20), 150);
  EXPECT_GT(text_width(fitted, 20), 110);
  EXPECT_TRUE(fitted.starts_with("a very"));
  EXPECT_TRUE(fitted.ends_with("…"));
}

CompareSheet sheet_of(std::size_t levels, std::size_t frames, std::uint32_t width, std::uint32_t height) {
  CompareSheet sheet{"world", {"how to read it"}, {{"source", {"the full detail"}}}, {}};
  for (std::size_t l = 0; l < levels; ++l) sheet.columns.push_back({"level", {"within 1 m"}});
  const std::uint32_t tile = sheet_tile_width(width, height);
  const std::uint32_t tall = std::max(1U, height * tile / width);
  for (std::size_t f = 0; f < frames; ++f) {
    SheetRow row{"frame", {"eye"}, {{blank_picture(tile, tall, {10, 200, 30})}}};
    for (std::size_t l = 0; l < levels; ++l)
      row.cells.push_back({blank_picture(tile, tall, {200, 10, 30}), blank_picture(tile, tall, {1, 2, 250}), "FLIP 0"});
    sheet.rows.push_back(std::move(row));
  }
  return sheet;
}

TEST(CompareSheet, ShowsEveryPictureWholeAndItsDifferenceBelow) {
  for (const std::size_t levels : {1U, 2U, 7U, 9U})
    for (const std::size_t frames : {1U, 5U, 12U}) {
      const Picture sheet = draw_compare_sheet(sheet_of(levels, frames, 1280, 720));
      const auto tile = static_cast<int>(320 * 180 * frames);
      EXPECT_EQ(all_of(sheet, {10, 200, 30}), tile);
      EXPECT_EQ(all_of(sheet, {200, 10, 30}), tile * static_cast<int>(levels));
      EXPECT_EQ(all_of(sheet, {1, 2, 250}), tile * static_cast<int>(levels));
    }
}

TEST(CompareSheet, IsOfASizeToLookAtWhateverThePictures) {
  for (const auto& [width, height] : {std::pair{1280U, 720U}, {4096U, 8U}, {8U, 4096U}, {4096U, 4096U}, {64U, 36U}})
    for (const std::size_t levels : {1U, 3U, 9U}) {
      const Picture sheet = draw_compare_sheet(sheet_of(levels, kSheetRowLimit, width, height));
      EXPECT_LE(sheet.width, 3600U) << width << " x " << height;
      EXPECT_LE(sheet.height, 13000U) << width << " x " << height;
      EXPECT_GE(sheet.width, 400U);
    }
}

TEST(CompareSheet, SaysWhatItsColumnsRowsAndColoursAre) {
  const CompareSheet full = sheet_of(2, 1, 1280, 720);
  const Picture with_all = draw_compare_sheet(full);
  const auto differs = [&](const auto& change) {
    CompareSheet other = full;
    change(other);
    const Picture without = draw_compare_sheet(other);
    return without.width == with_all.width && without.height == with_all.height && without.rgba != with_all.rgba;
  };
  EXPECT_TRUE(differs([](CompareSheet& s) { s.title.clear(); }));
  EXPECT_TRUE(differs([](CompareSheet& s) { s.lines[0].clear(); }));
  EXPECT_TRUE(differs([](CompareSheet& s) { s.columns[2].title.clear(); }));
  EXPECT_TRUE(differs([](CompareSheet& s) { s.columns[0].lines[0].clear(); }));
  EXPECT_TRUE(differs([](CompareSheet& s) { s.rows[0].name.clear(); }));
  EXPECT_TRUE(differs([](CompareSheet& s) { s.rows[0].lines[0].clear(); }));
  EXPECT_TRUE(differs([](CompareSheet& s) { s.rows[0].cells[1].caption.clear(); }));
  for (const int i : {40, 100, 200, 319}) {  // the legend has every colour
    const float share = static_cast<float>(i) / 319;
    EXPECT_GT(all_of(with_all, flip_color(share * share)), 5) << i;
  }
}

TEST(FlipColor, GetsBrighterAndShowsADifferenceThatIsJustSeen) {
  const auto light = [](float difference) {
    const Rgb c = flip_color(difference);
    return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
  };
  for (int i = 1; i <= 100; ++i)
    EXPECT_GT(light(static_cast<float>(i) / 100), light(static_cast<float>(i - 1) / 100)) << i;
  EXPECT_GT(light(0.05F), light(0) + 15);
  EXPECT_EQ(flip_color(-1), flip_color(0));
  EXPECT_EQ(flip_color(2), flip_color(1));
}

TEST(FlipPicture, IsScaledDownByTheMeanOfTheDifferences) {
  const Picture picture = flip_picture({0, 1, 0, 0}, 2, 2, 1);
  ASSERT_EQ(picture.rgba.size(), 4U);
  EXPECT_EQ(pixel(picture, 0, 0), flip_color(0.25F));
}

}  // namespace
}  // namespace zc
