// SPDX-License-Identifier: GPL-3.0-or-later
#include <turbojpeg.h>

#include <limits>
#include <memory>
#include <string>
#include <string_view>

#include "baker/import/images/formats.h"

namespace zc {
namespace {

// A block of 64 pixels takes at least a bit, in the scan of its means alone.
constexpr std::uint64_t kPixelsPerByte = 512;

// The largest of the library's scales under which the picture is small enough.
tjscalingfactor scale_for(std::uint64_t pixels) {
  for (int below = 1; below < 8; below *= 2)
    if (pixels / static_cast<std::uint64_t>(below * below) <= kDecodedPixels) return {1, below};
  return {1, 8};
}

// Inks, stored inverted as Adobe's programs do, to sRGB.
DecodedImage rgb_of_inks(const std::vector<std::uint8_t>& inks, std::uint32_t width, std::uint32_t height) {
  DecodedImage image{width, height, 3, {}};
  image.pixels.resize(inks.size() / 4 * 3);
  for (std::size_t i = 0; i < inks.size() / 4; ++i)
    for (std::size_t c = 0; c < 3; ++c)
      image.pixels[3 * i + c] = static_cast<std::uint8_t>(inks[4 * i + c] * inks[4 * i + 3] / 255);
  return image;
}

}  // namespace

Result<DecodedImage> decode_jpeg(std::span<const std::byte> encoded) {
  const std::unique_ptr<void, decltype(&tjDestroy)> decoder(tjInitDecompress(), &tjDestroy);
  if (decoder == nullptr) return Error{ErrorCode::kIo, "no memory"};
  const auto cause = [&] { return Error{ErrorCode::kFormat, tjGetErrorStr2(decoder.get())}; };
  const auto* data = reinterpret_cast<const unsigned char*>(encoded.data());
  if (encoded.size() > std::numeric_limits<unsigned>::max()) return Error{ErrorCode::kUnsupported, "more than 4 GiB"};
  int width = 0;
  int height = 0;
  int subsampling = 0;
  int colors = 0;
  if (tjDecompressHeader3(decoder.get(), data, encoded.size(), &width, &height, &subsampling, &colors) != 0)
    return cause();
  const auto wide = static_cast<std::uint64_t>(width);
  const auto high = static_cast<std::uint64_t>(height);
  ZC_TRY(check_size(wide, high, encoded.size(), kPixelsPerByte));
  const tjscalingfactor scale = scale_for(wide * high);
  width = TJSCALED(width, scale);
  height = TJSCALED(height, scale);
  const bool is_inks = colors == TJCS_CMYK || colors == TJCS_YCCK;
  const bool is_grey = colors == TJCS_GRAY;
  const int format = is_inks ? TJPF_CMYK : is_grey ? TJPF_GRAY : TJPF_RGB;
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                                   static_cast<std::size_t>(tjPixelSize[format]));
  const auto decode = [&](int flags) {
    return tjDecompress2(decoder.get(), data, encoded.size(), pixels.data(), width, 0, height, format,
                         TJFLAG_LIMITSCANS | TJFLAG_ACCURATEDCT | flags);
  };
  if (decode(TJFLAG_STOPONWARNING) != 0) {
    // Many cameras write a few bytes too many: the picture is whole.
    if (std::string_view(tjGetErrorStr2(decoder.get())).find("extraneous") == std::string_view::npos) return cause();
    if (decode(0) != 0 && tjGetErrorCode(decoder.get()) != TJERR_WARNING) return cause();
  }
  if (is_inks) return rgb_of_inks(pixels, static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height));
  return DecodedImage{static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height), is_grey ? 1U : 3U,
                      std::move(pixels)};
}

}  // namespace zc
