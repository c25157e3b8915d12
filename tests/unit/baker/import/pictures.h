// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures that the tests code themselves.
#pragma once

#include <gtest/gtest.h>
#include <spng.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <vector>

namespace zc::test {

using Bytes = std::vector<std::byte>;

// Left red, right blue; with alpha the lower half is transparent.
inline std::vector<std::uint8_t> picture(std::uint32_t width, std::uint32_t height, std::uint32_t channels) {
  std::vector<std::uint8_t> pixels;
  for (std::uint32_t y = 0; y < height; ++y)
    for (std::uint32_t x = 0; x < width; ++x) {
      const bool left = x < width / 2;
      const std::array<std::uint8_t, 4> texel = {static_cast<std::uint8_t>(left ? 250 : 10), 20,
                                                 static_cast<std::uint8_t>(left ? 10 : 250),
                                                 static_cast<std::uint8_t>(y < height / 2 ? 255 : 0)};
      pixels.insert(pixels.end(), texel.begin(), texel.begin() + channels);
    }
  return pixels;
}

inline Bytes bytes_of(const void* data, std::size_t size) {
  const auto* begin = static_cast<const std::byte*>(data);
  return {begin, begin + size};
}

inline Bytes png_of(const std::vector<std::uint8_t>& pixels, std::uint32_t width, std::uint32_t height,
                    std::uint32_t channels, bool interlaced = false) {
  const std::unique_ptr<spng_ctx, decltype(&spng_ctx_free)> coder(spng_ctx_new(SPNG_CTX_ENCODER), &spng_ctx_free);
  spng_ihdr header{};
  header.width = width;
  header.height = height;
  header.bit_depth = 8;
  header.color_type = static_cast<std::uint8_t>(channels == 4   ? SPNG_COLOR_TYPE_TRUECOLOR_ALPHA
                                                : channels == 1 ? SPNG_COLOR_TYPE_GRAYSCALE
                                                                : SPNG_COLOR_TYPE_TRUECOLOR);
  header.interlace_method = interlaced ? 1 : 0;
  spng_set_option(coder.get(), SPNG_ENCODE_TO_BUFFER, 1);
  spng_set_ihdr(coder.get(), &header);
  EXPECT_EQ(spng_encode_image(coder.get(), pixels.data(), pixels.size(), SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE), 0);
  std::size_t size = 0;
  int fault = 0;
  const std::unique_ptr<void, decltype(&std::free)> out(spng_get_png_buffer(coder.get(), &size, &fault), &std::free);
  return bytes_of(out.get(), size);
}

inline Bytes png(std::uint32_t width, std::uint32_t height, std::uint32_t channels, bool interlaced = false) {
  return png_of(picture(width, height, channels), width, height, channels, interlaced);
}

}  // namespace zc::test
