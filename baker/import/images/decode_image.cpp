// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/images/decode_image.h"

#include <algorithm>
#include <array>
#include <string>

#include "baker/import/images/formats.h"

namespace zc {
namespace {

template <std::size_t N>
bool begins_with(std::span<const std::byte> bytes, const std::array<unsigned char, N>& start, std::size_t at = 0) {
  return bytes.size() >= at + N &&
         std::equal(start.begin(), start.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at),
                    [](unsigned char a, std::byte b) { return std::byte{a} == b; });
}

Result<DecodedImage> named(const char* format, Result<DecodedImage> image) {
  if (image.ok()) return image;
  Error error = std::move(image).error();
  error.message = std::string(format) + ": " + error.message;
  return error;
}

}  // namespace

Status check_size(std::uint64_t width, std::uint64_t height, std::uint64_t encoded_bytes,
                  std::uint64_t pixels_per_byte) {
  const std::string size = std::to_string(width) + " × " + std::to_string(height) + " pixels";
  if (width == 0 || height == 0 || width > kImageSideMost || height > kImageSideMost)
    return Error{ErrorCode::kFormat, size + ", sides of 1 to " + std::to_string(kImageSideMost) + " are read"};
  if (width * height / pixels_per_byte > encoded_bytes)
    return Error{ErrorCode::kFormat,
                 size + " are more than " + std::to_string(encoded_bytes) + " bytes can hold: the file is damaged"};
  return {};
}

Result<DecodedImage> decode_image(std::span<const std::byte> encoded) {
  if (begins_with<3>(encoded, {0xFF, 0xD8, 0xFF})) return named("JPEG", decode_jpeg(encoded));
  if (begins_with<8>(encoded, {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'})) return named("PNG", decode_png(encoded));
  if (begins_with<4>(encoded, {'R', 'I', 'F', 'F'}) && begins_with<4>(encoded, {'W', 'E', 'B', 'P'}, 8))
    return named("WebP", decode_webp(encoded));
  if (begins_with<12>(encoded, {0xAB, 'K', 'T', 'X', ' ', '2', '0', 0xBB, '\r', '\n', 0x1A, '\n'}))
    return named("KTX2", decode_ktx2(encoded));
  if (encoded.empty()) return Error{ErrorCode::kFormat, "no bytes"};
  return Error{ErrorCode::kUnsupported, "none of JPEG, PNG, WebP and KTX2"};
}

}  // namespace zc
