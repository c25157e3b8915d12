// SPDX-License-Identifier: GPL-3.0-or-later
#include <spng.h>

#include <algorithm>
#include <memory>
#include <string>

#include "baker/import/images/formats.h"

namespace zc {
namespace {

// Deflate makes at most 1,032 bytes of one, and a pixel may take a bit.
constexpr std::uint64_t kPixelsPerByte = 8 * 1032;
constexpr std::size_t kChunkBytes = 16U << 20U;  // of text, profiles and the like

using Context = std::unique_ptr<spng_ctx, decltype(&spng_ctx_free)>;

Error fault(int code) { return {ErrorCode::kFormat, spng_strerror(code)}; }

// So that of every 2^k by 2^k pixels one is kept, their mean.
std::uint32_t reduction(std::uint64_t pixels) {
  std::uint32_t k = 0;
  while ((pixels >> (2 * k)) > kDecodedPixels) ++k;
  return k;
}

// Rows as they come, one for 2^k.
class Reduced {
 public:
  Reduced(std::uint32_t width, std::uint32_t height, std::uint32_t channels, std::uint32_t k)
      : side_(1U << k), from_width_(width) {
    image.width = (width + side_ - 1) / side_;
    image.height = (height + side_ - 1) / side_;
    image.channels = channels;
    image.pixels.reserve(std::size_t{image.width} * image.height * channels);
    sums_.resize(std::size_t{image.width} * channels);
  }
  void add(std::span<const std::uint8_t> row) {
    const std::size_t channels = image.channels;
    for (std::uint32_t x = 0; x < from_width_; ++x)
      for (std::size_t c = 0; c < channels; ++c) sums_[x / side_ * channels + c] += row[x * channels + c];
    if (++rows_ == side_) flush();
  }
  void flush() {
    if (rows_ == 0) return;
    for (std::uint32_t x = 0; x < image.width; ++x) {
      const std::uint32_t count = std::min(side_, from_width_ - x * side_) * rows_;
      for (std::size_t c = 0; c < image.channels; ++c)
        image.pixels.push_back(static_cast<std::uint8_t>((sums_[x * image.channels + c] + count / 2) / count));
    }
    std::ranges::fill(sums_, 0U);
    rows_ = 0;
  }

  DecodedImage image;

 private:
  std::uint32_t side_, from_width_;
  std::uint32_t rows_ = 0;
  std::vector<std::uint32_t> sums_;
};

}  // namespace

Result<DecodedImage> decode_png(std::span<const std::byte> encoded) {
  const Context context(spng_ctx_new(SPNG_CTX_IGNORE_ADLER32), &spng_ctx_free);
  if (context == nullptr) return Error{ErrorCode::kIo, "no memory"};
  spng_set_image_limits(context.get(), kImageSideMost, kImageSideMost);
  spng_set_chunk_limits(context.get(), kChunkBytes, kChunkBytes);
  spng_set_crc_action(context.get(), SPNG_CRC_USE, SPNG_CRC_USE);  // a wrong sum beside a right picture is common
  int code = spng_set_png_buffer(context.get(), encoded.data(), encoded.size());
  spng_ihdr header{};
  if (code == 0) code = spng_get_ihdr(context.get(), &header);
  if (code != 0) return fault(code);
  ZC_TRY(check_size(header.width, header.height, encoded.size(), kPixelsPerByte));
  const std::uint64_t pixels = std::uint64_t{header.width} * header.height;
  const std::uint32_t k = reduction(pixels);
  const bool interlaced = header.interlace_method != 0;
  if (interlaced && k > 0)
    return Error{ErrorCode::kUnsupported, std::to_string(header.width) + " × " + std::to_string(header.height) +
                                              " pixels, interlaced: save it without interlacing"};
  spng_trns transparent{};
  const bool has_alpha = (header.color_type & 4U) != 0 || spng_get_trns(context.get(), &transparent) == 0;
  const spng_format format = has_alpha ? SPNG_FMT_RGBA8 : SPNG_FMT_RGB8;
  const std::uint32_t channels = has_alpha ? 4 : 3;
  const int flags = has_alpha ? SPNG_DECODE_TRNS : 0;
  if (interlaced) {
    DecodedImage image{header.width, header.height, channels, std::vector<std::uint8_t>(pixels * channels)};
    code = spng_decode_image(context.get(), image.pixels.data(), image.pixels.size(), format, flags);
    if (code != 0) return fault(code);
    return image;
  }
  code = spng_decode_image(context.get(), nullptr, 0, format, flags | SPNG_DECODE_PROGRESSIVE);
  if (code != 0) return fault(code);
  Reduced reduced(header.width, header.height, channels, k);
  std::vector<std::uint8_t> row(std::size_t{header.width} * channels);
  for (std::uint32_t y = 0; y < header.height; ++y) {
    code = spng_decode_row(context.get(), row.data(), row.size());
    if (code != 0 && code != SPNG_EOI) return fault(code);
    reduced.add(row);
  }
  reduced.flush();
  return std::move(reduced.image);
}

}  // namespace zc
