// SPDX-License-Identifier: GPL-3.0-or-later
// One decoder a format, for decode_image(). Each fails with the cause alone. Thread-safe: no state.
#pragma once

#include "baker/import/images/decode_image.h"

namespace zc {

Result<DecodedImage> decode_jpeg(std::span<const std::byte> encoded);
Result<DecodedImage> decode_ktx2(std::span<const std::byte> encoded);
Result<DecodedImage> decode_png(std::span<const std::byte> encoded);
Result<DecodedImage> decode_webp(std::span<const std::byte> encoded);

// Fails when no file of this size can hold so many pixels, or none of such sides is read. pixels_per_byte: the most
// that the format's coding allows.
Status check_size(std::uint64_t width, std::uint64_t height, std::uint64_t encoded_bytes,
                  std::uint64_t pixels_per_byte);

}  // namespace zc
