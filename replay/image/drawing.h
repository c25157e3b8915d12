// SPDX-License-Identifier: Apache-2.0
// Rectangles, pictures and text drawn into a picture; what lies outside it is cut off. Units: pixels, y down.
// Text is UTF-8 in DejaVu Sans, which the build takes from the system and puts into the program. Thread-safe: no state.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "replay/image/png_file.h"

namespace zc {

using Rgb = std::array<std::uint8_t, 3>;  // sRGB

Picture blank_picture(std::uint32_t width, std::uint32_t height, Rgb color);
void fill_rectangle(Picture& picture, int x, int y, int width, int height, Rgb color);
void paste(Picture& picture, const Picture& other, int x, int y);

// size: from the top of the highest letters to the bottom of the lowest, which is what a line takes.
int text_width(std::string_view text, int size);
void draw_text(Picture& picture, int x, int y, std::string_view text, int size, Rgb color);
// The text, or as much of it as is no wider, and an ellipsis.
std::string fit_text(std::string_view text, int size, int width);

}  // namespace zc
