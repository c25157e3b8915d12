// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/shared/texture_images.h"

#include "baker/import/shared/scene_builder.h"

namespace zc {
namespace {

constexpr std::uint64_t kMaxImageBytes = 256U << 20U;
// Of all images together, 3 bytes each: beyond it they all lose their finest level.
constexpr std::uint64_t kMaxTexels = 1U << 28U;

// Of the last channel; null when all is opaque.
std::unique_ptr<AlphaMask> opaque_mask(const DecodedImage& image) {
  auto mask = std::make_unique<AlphaMask>(image.pixels, image.width, image.height, image.channels);
  return mask->share_at_least(1) < 1 ? std::move(mask) : nullptr;
}

// Grey images are their own alpha.
DecodedImage with_alpha(DecodedImage image) {
  if (image.channels == 3) {
    for (std::size_t i = 0; i < image.pixels.size() / 3; ++i) {
      // Luma of ITU-R BT.601, of 256 parts.
      const unsigned sum = 77U * image.pixels[3 * i] + 150U * image.pixels[3 * i + 1] + 29U * image.pixels[3 * i + 2];
      image.pixels[i] = static_cast<std::uint8_t>(sum >> 8U);
    }
    image.pixels.resize(image.pixels.size() / 3);
    image.channels = 1;
  }
  return image;
}

}  // namespace

std::optional<LoadedImage> TextureImages::add(const std::string& name, std::span<const std::byte> encoded) {
  const std::optional<DecodedImage> pixels = decoded(name, encoded);
  if (!pixels) return std::nullopt;
  TextureImage image = make_texture_image(pixels->pixels, pixels->width, pixels->height, pixels->channels);
  const auto drop_finest = [](TextureImage& of) {
    if (of.levels.size() > 1) of.levels.erase(of.levels.begin());
  };
  for (std::uint32_t i = 0; i < dropped_levels_; ++i) drop_finest(image);
  texels_ += image.texel_count();
  images_.push_back(std::move(image));
  masks_.emplace_back();
  if (pixels->channels % 2 == 0) masks_.back() = opaque_mask(*pixels);
  while (texels_ > kMaxTexels && texels_ > images_.size()) {
    ++dropped_levels_;
    texels_ = 0;
    for (TextureImage& kept : images_) {
      drop_finest(kept);
      texels_ += kept.texel_count();
    }
  }
  return LoadedImage{static_cast<std::uint32_t>(images_.size() - 1), images_.back().mean};
}

std::optional<LoadedImage> TextureImages::of_file(const Result<std::filesystem::path>& file, const std::string& name,
                                                  const InputFiles& files) {
  const auto [slot, is_new] = known_.try_emplace(file.ok() ? file->string() : file.error().describe());
  if (!is_new) return slot->second;
  if (const auto bytes = bytes_of(file, name, files)) slot->second = add(name, *bytes);
  return slot->second;
}

const AlphaMask* TextureImages::coverage_of_file(const Result<std::filesystem::path>& file, const std::string& name,
                                                 const InputFiles& files) {
  const auto [slot, is_new] = coverages_.try_emplace(file.ok() ? file->string() : file.error().describe());
  if (!is_new) return slot->second.get();
  const auto bytes = bytes_of(file, name, files);
  std::optional<DecodedImage> pixels = bytes ? decoded(name, *bytes) : std::nullopt;
  if (pixels) slot->second = opaque_mask(with_alpha(std::move(*pixels)));
  return slot->second.get();
}

std::optional<DecodedImage> TextureImages::decoded(const std::string& name, std::span<const std::byte> encoded) {
  Result<DecodedImage> image = decode_image(encoded);
  if (image.ok()) return std::move(*image);
  unreadable_.push_back(name + " (" + image.error().message + ")");
  return std::nullopt;
}

// What cannot be read is kept for report().
std::optional<std::vector<std::byte>> TextureImages::bytes_of(const Result<std::filesystem::path>& file,
                                                              const std::string& name, const InputFiles& files) {
  if (!file.ok()) {
    outside_.push_back(name);
    return std::nullopt;
  }
  Result<std::vector<std::byte>> bytes = files.read(*file, kMaxImageBytes);
  if (bytes.ok()) return std::move(*bytes);
  missing_.push_back(name);
  return std::nullopt;
}

std::optional<LoadedImage> TextureImages::of_bytes(const std::string& key, std::span<const std::byte> encoded) {
  const auto [slot, is_new] = known_.try_emplace(key);
  if (!is_new) return slot->second;
  slot->second = add(key, encoded);
  return slot->second;
}

void TextureImages::report(SceneBuilder& builder) const {
  builder.note_files("missing texture images, plain colours used", missing_);
  builder.note_files("texture images that lie outside the folder of their input, not read, plain colours used",
                     outside_);
  builder.note_files("texture images that cannot be decoded, plain colours used", unreadable_);
  if (dropped_levels_ > 0)
    builder.note("finest levels of every texture image left out, to bound memory", dropped_levels_);
}

}  // namespace zc
