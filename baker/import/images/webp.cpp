// SPDX-License-Identifier: GPL-3.0-or-later
#include <webp/decode.h>

#include <algorithm>
#include <cmath>

#include "baker/import/images/formats.h"

namespace zc {
namespace {

// A lossless picture of one colour codes any number of pixels in a few bytes; the sides are 14 bits.
constexpr std::uint64_t kPixelsPerByte = std::uint64_t{1} << 40U;

const char* cause(VP8StatusCode code) {
  switch (code) {
    case VP8_STATUS_OUT_OF_MEMORY:
      return "no memory";
    case VP8_STATUS_NOT_ENOUGH_DATA:
      return "ends early";
    case VP8_STATUS_UNSUPPORTED_FEATURE:
      return "a feature that libwebp does not read";
    default:
      return "damaged";
  }
}

}  // namespace

Result<DecodedImage> decode_webp(std::span<const std::byte> encoded) {
  const auto* data = reinterpret_cast<const std::uint8_t*>(encoded.data());
  WebPDecoderConfig config;
  if (WebPInitDecoderConfig(&config) == 0) return Error{ErrorCode::kIo, "libwebp is another version"};
  if (const VP8StatusCode code = WebPGetFeatures(data, encoded.size(), &config.input); code != VP8_STATUS_OK)
    return Error{ErrorCode::kFormat, cause(code)};
  if (config.input.has_animation != 0) return Error{ErrorCode::kUnsupported, "an animation"};
  const auto width = static_cast<std::uint32_t>(std::max(config.input.width, 0));
  const auto height = static_cast<std::uint32_t>(std::max(config.input.height, 0));
  ZC_TRY(check_size(width, height, encoded.size(), kPixelsPerByte));
  DecodedImage image{width, height, config.input.has_alpha != 0 ? 4U : 3U, {}};
  // libwebp keeps a lossless picture at its full size while it scales it.
  constexpr std::uint64_t kLosslessMost = 4 * kDecodedPixels;
  const std::uint64_t pixels = std::uint64_t{width} * height;
  if (pixels > (config.input.format == 2 ? kLosslessMost : std::uint64_t{1} << 28U))
    return Error{ErrorCode::kUnsupported, "too many pixels: at most " + std::to_string(kLosslessMost) + " are read"};
  for (std::uint32_t by = 2; std::uint64_t{image.width} * image.height > kDecodedPixels; by *= 2) {
    image.width = (width + by - 1) / by;
    image.height = (height + by - 1) / by;
    config.options.use_scaling = 1;
    config.options.scaled_width = static_cast<int>(image.width);
    config.options.scaled_height = static_cast<int>(image.height);
  }
  image.pixels.resize(std::size_t{image.width} * image.height * image.channels);
  config.output.colorspace = image.channels == 4 ? MODE_RGBA : MODE_RGB;
  config.output.is_external_memory = 1;
  config.output.u.RGBA.rgba = image.pixels.data();
  config.output.u.RGBA.stride = static_cast<int>(image.width * image.channels);
  config.output.u.RGBA.size = image.pixels.size();
  const VP8StatusCode code = WebPDecode(data, encoded.size(), &config);
  WebPFreeDecBuffer(&config.output);
  if (code != VP8_STATUS_OK) return Error{ErrorCode::kFormat, cause(code)};
  return image;
}

}  // namespace zc
