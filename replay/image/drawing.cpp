// SPDX-License-Identifier: Apache-2.0
#include "replay/image/drawing.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "base/check.h"

#define STB_TRUETYPE_IMPLEMENTATION
#define STBTT_STATIC
#include <stb/stb_truetype.h>

// Made by the build.
extern "C" const unsigned char zonecast_label_font[];

namespace zc {
namespace {

const stbtt_fontinfo& font() {
  static const stbtt_fontinfo info = [] {
    stbtt_fontinfo out;
    ZC_CHECK(stbtt_InitFont(&out, zonecast_label_font, 0) != 0);
    return out;
  }();
  return info;
}

constexpr char32_t kReplacement = 0xFFFD;

// Takes a code point off the front. What is none becomes the replacement character, byte by byte.
char32_t take_code_point(std::string_view& text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  const std::size_t length = first < 0x80 ? 1 : first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : first >= 0xC0 ? 2 : 0;
  char32_t code = length == 1 ? first : first & (0x7FU >> length);
  bool good = length > 0 && length <= text.size() && first < 0xF8 && first >= (length == 1 ? 0x20 : 0xC0);
  for (std::size_t i = 1; good && i < length; ++i) {
    good = (byte(i) & 0xC0U) == 0x80;
    code = (code << 6U) | (byte(i) & 0x3FU);
  }
  text.remove_prefix(good ? length : 1);
  return good ? code : kReplacement;
}

// draw(code point, pen, in pixels from the text's beginning) for each of them; the width of all.
template <class Draw>
float each_glyph(std::string_view text, int size, const Draw& draw) {
  const float scale = stbtt_ScaleForPixelHeight(&font(), static_cast<float>(size));
  float pen = 0;
  while (!text.empty()) {
    const auto code = static_cast<int>(take_code_point(text));
    int advance = 0;
    stbtt_GetCodepointHMetrics(&font(), code, &advance, nullptr);
    draw(code, pen);
    pen += static_cast<float>(advance) * scale;
  }
  return pen;
}

}  // namespace

Picture blank_picture(std::uint32_t width, std::uint32_t height, Rgb color) {
  Picture out{width, height, std::vector<std::uint8_t>(std::size_t{4} * width * height, 255)};
  fill_rectangle(out, 0, 0, static_cast<int>(width), static_cast<int>(height), color);
  return out;
}

void fill_rectangle(Picture& picture, int x, int y, int width, int height, Rgb color) {
  const int right = std::min(x + width, static_cast<int>(picture.width));
  const int bottom = std::min(y + height, static_cast<int>(picture.height));
  for (int row = std::max(y, 0); row < bottom; ++row)
    for (int column = std::max(x, 0); column < right; ++column)
      std::ranges::copy(color, picture.rgba.begin() + (std::ptrdiff_t{row} * picture.width + column) * 4);
}

void paste(Picture& picture, const Picture& other, int x, int y) {
  const int left = std::max(x, 0);
  const int right = std::min(x + static_cast<int>(other.width), static_cast<int>(picture.width));
  const int bottom = std::min(y + static_cast<int>(other.height), static_cast<int>(picture.height));
  if (left >= right) return;
  for (int row = std::max(y, 0); row < bottom; ++row)
    std::copy_n(other.rgba.begin() + (std::ptrdiff_t{row - y} * other.width + (left - x)) * 4, (right - left) * 4,
                picture.rgba.begin() + (std::ptrdiff_t{row} * picture.width + left) * 4);
}

int text_width(std::string_view text, int size) {
  return static_cast<int>(std::ceil(each_glyph(text, size, [](int, float) {})));
}

void draw_text(Picture& picture, int x, int y, std::string_view text, int size, Rgb color) {
  const float scale = stbtt_ScaleForPixelHeight(&font(), static_cast<float>(size));
  int ascent = 0;
  stbtt_GetFontVMetrics(&font(), &ascent, nullptr, nullptr);
  const int baseline = y + static_cast<int>(std::lround(static_cast<float>(ascent) * scale));
  std::vector<std::uint8_t> coverage;
  each_glyph(text, size, [&](int code, float pen) {
    const float whole = std::floor(pen);
    int left = 0, top = 0, right = 0, bottom = 0;
    stbtt_GetCodepointBitmapBoxSubpixel(&font(), code, scale, scale, pen - whole, 0, &left, &top, &right, &bottom);
    const int width = right - left;
    const int height = bottom - top;
    if (width <= 0 || height <= 0) return;
    coverage.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0);
    stbtt_MakeCodepointBitmapSubpixel(&font(), coverage.data(), width, height, width, scale, scale, pen - whole, 0,
                                      code);
    for (int row = 0; row < height; ++row)
      for (int column = 0; column < width; ++column) {
        const int px = x + static_cast<int>(whole) + left + column;
        const int py = baseline + top + row;
        if (px < 0 || py < 0 || px >= static_cast<int>(picture.width) || py >= static_cast<int>(picture.height))
          continue;
        const int share = coverage[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                                   static_cast<std::size_t>(column)];
        std::uint8_t* pixel = picture.rgba.data() + (std::ptrdiff_t{py} * picture.width + px) * 4;
        for (std::size_t c = 0; c < color.size(); ++c)
          pixel[c] = static_cast<std::uint8_t>((pixel[c] * (255 - share) + color[c] * share + 127) / 255);
      }
  });
}

std::string fit_text(std::string_view text, int size, int width) {
  if (text_width(text, size) <= width) return std::string(text);
  std::string fitting;
  for (std::string_view rest = text; !rest.empty();) {
    take_code_point(rest);
    std::string longer(text.substr(0, text.size() - rest.size()));
    if (text_width(longer + "…", size) > width) break;
    fitting = std::move(longer);
  }
  return fitting + "…";
}

}  // namespace zc
