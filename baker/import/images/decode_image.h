// SPDX-License-Identifier: GPL-3.0-or-later
// Encoded images to pixels, each format by its library: JPEG (libjpeg-turbo), PNG (libspng), WebP (libwebp); of KTX2
// those of plain texels. Untrusted input: what no file of this size can hold is refused before memory is taken, and
// images larger than a texture needs are reduced while they are decoded, so that one takes at most kDecodedPixels
// pixels. Thread-safe: no state.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/result.h"

namespace zc {

struct DecodedImage {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t channels = 3;  // 1 grey, 2 grey and alpha, 3 sRGB, 4 sRGB and alpha
  std::vector<std::uint8_t> pixels;
};

inline constexpr std::uint64_t kDecodedPixels = std::uint64_t{1} << 25U;  // 5,792 × 5,792
inline constexpr std::uint32_t kImageSideMost = 65535;

// The error names the format and the cause, as "JPEG: …".
Result<DecodedImage> decode_image(std::span<const std::byte> encoded);

}  // namespace zc
