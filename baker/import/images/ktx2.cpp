// SPDX-License-Identifier: GPL-3.0-or-later
// KTX File Format Specification, version 2.0 (Khronos): the container, and texels of bytes. What Basis Universal coded
// (BasisLZ, UASTC) and blocks of GPUs are refused by their names: no library of Debian 12 decodes them.
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <string_view>

#include "baker/import/images/formats.h"

namespace zc {
namespace {

using namespace std::string_view_literals;

constexpr std::size_t kHeaderBytes = 80;
constexpr std::size_t kLevelBytes = 24;
constexpr std::uint32_t kNoScheme = 0;
constexpr std::uint32_t kBasisLz = 1;
constexpr std::uint32_t kZstandard = 2;
constexpr std::uint32_t kZlib = 3;
constexpr std::uint8_t kUastcModel = 166;
constexpr std::uint32_t kMaxLevels = 31;
constexpr const char* kConvert =
    "which is not read; write PNG instead, for example with gltf-transform from npm: gltf-transform ktxdecompress";
// Zstandard codes runs of any length in a few bytes: the sides bound them.
constexpr std::uint64_t kPixelsPerByte = std::uint64_t{1} << 40U;

struct TexelFormat {
  std::uint32_t unorm;  // of Vulkan's VkFormat
  std::uint32_t srgb;
  std::uint32_t channels;
  bool is_bgr;
};
constexpr std::array<TexelFormat, 6> kFormats = {{{9, 15, 1, false},
                                                  {16, 22, 2, false},
                                                  {23, 29, 3, false},
                                                  {30, 36, 3, true},
                                                  {37, 43, 4, false},
                                                  {44, 50, 4, true}}};

template <class T>
T number_at(std::span<const std::byte> bytes, std::uint64_t at) {
  T value{};
  if (at <= bytes.size() && sizeof value <= bytes.size() - at) std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

// Whether rows come from the bottom.
bool is_upwards(std::span<const std::byte> encoded) {
  const std::uint64_t at = number_at<std::uint32_t>(encoded, 56);
  const std::uint64_t length = number_at<std::uint32_t>(encoded, 60);
  if (at > encoded.size() || length > encoded.size() - at) return false;
  const std::string_view text(reinterpret_cast<const char*>(encoded.data()) + at, length);
  const std::size_t key = text.find("KTXorientation\0"sv);
  return key != std::string_view::npos && text.substr(key + 15).starts_with("ru");
}

// To exactly the size of `out`.
bool unpack(std::uint32_t scheme, std::span<const std::byte> packed, std::vector<std::uint8_t>& out) {
  if (scheme == kZstandard) {
    const std::size_t size = ZSTD_decompress(out.data(), out.size(), packed.data(), packed.size());
    return ZSTD_isError(size) == 0 && size == out.size();
  }
  if (scheme == kZlib) {
    uLongf size = out.size();
    return uncompress(out.data(), &size, reinterpret_cast<const Bytef*>(packed.data()), packed.size()) == Z_OK &&
           size == out.size();
  }
  if (packed.size() != out.size()) return false;
  std::memcpy(out.data(), packed.data(), packed.size());
  return true;
}

}  // namespace

Result<DecodedImage> decode_ktx2(std::span<const std::byte> encoded) {
  if (encoded.size() < kHeaderBytes + kLevelBytes) return Error{ErrorCode::kFormat, "ends early"};
  const auto vk_format = number_at<std::uint32_t>(encoded, 12);
  const auto scheme = number_at<std::uint32_t>(encoded, 44);
  const auto model = number_at<std::uint8_t>(encoded, std::uint64_t{number_at<std::uint32_t>(encoded, 48)} + 12);
  if (scheme == kBasisLz) return Error{ErrorCode::kUnsupported, std::string("BasisLZ, ") + kConvert};
  if (vk_format == 0 && model == kUastcModel) return Error{ErrorCode::kUnsupported, std::string("UASTC, ") + kConvert};
  const auto* format = std::find_if(kFormats.begin(), kFormats.end(),
                                    [&](const TexelFormat& f) { return f.unorm == vk_format || f.srgb == vk_format; });
  if (format == kFormats.end() || (scheme != kNoScheme && scheme != kZstandard && scheme != kZlib))
    return Error{ErrorCode::kUnsupported, "format " + std::to_string(vk_format) + " of Vulkan's with compression " +
                                              std::to_string(scheme) + ", " + kConvert};
  if (number_at<std::uint32_t>(encoded, 28) > 1 || number_at<std::uint32_t>(encoded, 32) > 1 ||
      number_at<std::uint32_t>(encoded, 36) != 1)
    return Error{ErrorCode::kUnsupported, "a volume, an array or a cube map, expected one picture"};
  const auto width = number_at<std::uint32_t>(encoded, 20);
  const auto height = number_at<std::uint32_t>(encoded, 24);
  ZC_TRY(check_size(width, height, encoded.size(), kPixelsPerByte));
  // The largest level that is not more than a texture needs.
  const std::uint32_t levels = std::clamp(number_at<std::uint32_t>(encoded, 40), 1U, kMaxLevels);
  DecodedImage image{width, height, format->channels, {}};
  std::uint32_t level = 0;
  for (; std::uint64_t{image.width} * image.height > kDecodedPixels; ++level) {
    if (level + 1 == levels)
      return Error{ErrorCode::kUnsupported,
                   "too many pixels without smaller levels: at most " + std::to_string(kDecodedPixels) + " are read"};
    image.width = std::max(image.width / 2, 1U);
    image.height = std::max(image.height / 2, 1U);
  }
  const std::uint64_t entry = kHeaderBytes + kLevelBytes * level;
  const auto at = number_at<std::uint64_t>(encoded, entry);
  const auto length = number_at<std::uint64_t>(encoded, entry + 8);
  if (at > encoded.size() || length > encoded.size() - at) return Error{ErrorCode::kFormat, "ends early"};
  image.pixels.resize(std::size_t{image.width} * image.height * image.channels);
  if (!unpack(scheme, encoded.subspan(at, length), image.pixels)) return Error{ErrorCode::kFormat, "damaged"};
  if (format->is_bgr)
    for (std::size_t i = 0; i < image.pixels.size(); i += image.channels)
      std::swap(image.pixels[i], image.pixels[i + 2]);
  const std::size_t row = std::size_t{image.width} * image.channels;
  for (std::size_t y = 0; is_upwards(encoded) && y < image.height / 2; ++y)
    std::swap_ranges(image.pixels.begin() + static_cast<std::ptrdiff_t>(y * row),
                     image.pixels.begin() + static_cast<std::ptrdiff_t>((y + 1) * row),
                     image.pixels.begin() + static_cast<std::ptrdiff_t>((image.height - 1 - y) * row));
  return image;
}

}  // namespace zc
