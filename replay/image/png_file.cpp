// SPDX-License-Identifier: Apache-2.0
#include "replay/image/png_file.h"

#include <spng.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <span>
#include <string_view>
#include <system_error>

#include "base/check.h"
#include "base/file.h"

namespace zc {
namespace {

constexpr std::string_view kWriter = "zonecast";

// Whether the text that write_png() puts behind the header is there.
bool written_here(const std::filesystem::path& file) {
  constexpr std::size_t kSignatureAndHeader = 8 + 25;
  std::string head(kSignatureAndHeader + 8 + 9 + kWriter.size(), '\0');
  if (!read_range(file, 0, std::as_writable_bytes(std::span(head)))) return false;
  return head.ends_with(std::string("tEXtSoftware\0", 13).append(kWriter));
}

}  // namespace

Status write_png(const std::filesystem::path& file, const Picture& picture) {
  // Frames carry no alpha; RGB files are a quarter smaller.
  std::vector<std::uint8_t> rgb;
  rgb.reserve(picture.rgba.size() / 4 * 3);
  for (std::size_t i = 0; i + 3 < picture.rgba.size(); i += 4)
    rgb.insert(rgb.end(), {picture.rgba[i], picture.rgba[i + 1], picture.rgba[i + 2]});
  const std::unique_ptr<spng_ctx, decltype(&spng_ctx_free)> context(spng_ctx_new(SPNG_CTX_ENCODER), &spng_ctx_free);
  spng_ihdr header{};
  header.width = picture.width;
  header.height = picture.height;
  header.bit_depth = 8;
  header.color_type = SPNG_COLOR_TYPE_TRUECOLOR;
  std::string writer(kWriter);
  spng_text text{};
  std::string_view("Software").copy(text.keyword, sizeof(text.keyword) - 1);
  text.type = SPNG_TEXT;
  text.text = writer.data();
  text.length = writer.size();
  int failure = spng_set_option(context.get(), SPNG_ENCODE_TO_BUFFER, 1);
  if (failure == 0) failure = spng_set_option(context.get(), SPNG_IMG_COMPRESSION_LEVEL, 3);
  if (failure == 0) failure = spng_set_ihdr(context.get(), &header);
  if (failure == 0) failure = spng_set_text(context.get(), &text, 1);
  if (failure == 0)
    failure = spng_encode_image(context.get(), rgb.data(), rgb.size(), SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE);
  std::size_t bytes = 0;
  const std::unique_ptr<void, decltype(&std::free)> encoded(
      failure == 0 ? spng_get_png_buffer(context.get(), &bytes, &failure) : nullptr, &std::free);
  if (failure != 0)
    return Error{ErrorCode::kIo, std::string("cannot encode PNG: ") + spng_strerror(failure), file.string()};
  return write_file(file, std::span(static_cast<const std::byte*>(encoded.get()), bytes));
}

Status remove_written_png(const std::filesystem::path& file) {
  std::error_code code;
  if (written_here(file) && !std::filesystem::remove(file, code))
    return Error{ErrorCode::kIo, "an earlier run's picture cannot be removed: " + code.message(), file.string()};
  return {};
}

Status remove_written_pngs(const std::filesystem::path& folder) {
  std::error_code code;
  std::vector<std::filesystem::path> pictures;
  for (std::filesystem::directory_iterator at(folder, code); !code && at != std::filesystem::directory_iterator();
       at.increment(code))
    if (at->path().extension() == ".png") pictures.push_back(at->path());
  for (const std::filesystem::path& picture : pictures) ZC_TRY(remove_written_png(picture));
  if (!pictures.empty()) std::filesystem::remove(folder, code);  // only where nothing else is in it
  return {};
}

Picture scale_down(const Picture& picture, std::uint32_t width) {
  width = std::min(width, picture.width);
  Picture out;
  out.width = width;
  out.height = std::max(1U, picture.height * width / picture.width);
  out.rgba.resize(std::size_t{4} * out.width * out.height);
  for (std::uint32_t y = 0; y < out.height; ++y) {
    const std::uint32_t y0 = y * picture.height / out.height;
    const std::uint32_t y1 = std::max(y0 + 1, (y + 1) * picture.height / out.height);
    for (std::uint32_t x = 0; x < out.width; ++x) {
      const std::uint32_t x0 = x * picture.width / out.width;
      const std::uint32_t x1 = std::max(x0 + 1, (x + 1) * picture.width / out.width);
      for (std::uint32_t channel = 0; channel < 4; ++channel) {
        std::uint32_t sum = 0;
        for (std::uint32_t sy = y0; sy < y1; ++sy) {
          for (std::uint32_t sx = x0; sx < x1; ++sx)
            sum += picture.rgba[(std::size_t{sy} * picture.width + sx) * 4 + channel];
        }
        out.rgba[(std::size_t{y} * out.width + x) * 4 + channel] =
            static_cast<std::uint8_t>(sum / ((y1 - y0) * (x1 - x0)));
      }
    }
  }
  return out;
}

Picture make_contact_sheet(const std::vector<Picture>& pictures, std::uint32_t columns, std::uint32_t tile_width) {
  ZC_CHECK(!pictures.empty() && columns > 0);
  std::vector<Picture> tiles;
  tiles.reserve(pictures.size());
  for (const Picture& picture : pictures) tiles.push_back(scale_down(picture, tile_width));
  constexpr std::uint32_t gap = 4;
  const std::uint32_t w = tiles[0].width + gap;
  const std::uint32_t h = tiles[0].height + gap;
  columns = std::min(columns, static_cast<std::uint32_t>(tiles.size()));
  const auto rows = (static_cast<std::uint32_t>(tiles.size()) + columns - 1) / columns;
  Picture sheet;
  sheet.width = columns * w + gap;
  sheet.height = rows * h + gap;
  sheet.rgba.assign(std::size_t{4} * sheet.width * sheet.height, 255);
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    const auto column = static_cast<std::uint32_t>(i) % columns;
    const auto row = static_cast<std::uint32_t>(i) / columns;
    for (std::uint32_t y = 0; y < tiles[i].height; ++y) {
      const auto from = tiles[i].rgba.begin() + static_cast<std::ptrdiff_t>(std::size_t{4} * y * tiles[i].width);
      const auto to = sheet.rgba.begin() + static_cast<std::ptrdiff_t>(
                                               (std::size_t{row * h + gap + y} * sheet.width + column * w + gap) * 4);
      std::copy_n(from, static_cast<std::ptrdiff_t>(tiles[i].width) * 4, to);
    }
  }
  return sheet;
}

}  // namespace zc
