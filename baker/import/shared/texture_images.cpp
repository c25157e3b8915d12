// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/shared/texture_images.h"

#include <memory>

#include "baker/import/shared/scene_builder.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_JPEG
#define STBI_ONLY_PNG
#define STBI_NO_STDIO
#define STBI_MAX_DIMENSIONS 32768
#include <stb/stb_image.h>
#pragma GCC diagnostic pop

namespace zc {
namespace {

constexpr std::uint64_t kMaxImageBytes = 256U << 20U;
constexpr std::int64_t kMaxPixels = 1 << 28;
// Of all images together, 3 bytes each: beyond it they all lose their finest level.
constexpr std::uint64_t kMaxTexels = 1U << 28U;

std::optional<TextureImage> decode(std::span<const std::byte> encoded) {
  if (encoded.empty() || encoded.size() > kMaxImageBytes) return std::nullopt;
  const auto* data = reinterpret_cast<const stbi_uc*>(encoded.data());
  const auto size = static_cast<int>(encoded.size());
  int width = 0;
  int height = 0;
  int channels = 0;
  if (stbi_info_from_memory(data, size, &width, &height, &channels) == 0) return std::nullopt;
  if (width <= 0 || height <= 0 || std::int64_t{width} * height > kMaxPixels) return std::nullopt;
  const std::unique_ptr<stbi_uc, decltype(&stbi_image_free)> pixels(
      stbi_load_from_memory(data, size, &width, &height, &channels, 0), &stbi_image_free);
  if (pixels == nullptr || width <= 0 || height <= 0 || channels < 1 || channels > 4) return std::nullopt;
  const std::size_t bytes =
      static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * static_cast<std::size_t>(channels);
  return make_texture_image({pixels.get(), bytes}, static_cast<std::uint32_t>(width),
                            static_cast<std::uint32_t>(height), static_cast<std::uint32_t>(channels));
}

}  // namespace

std::optional<LoadedImage> TextureImages::add(std::span<const std::byte> encoded) {
  std::optional<TextureImage> image = decode(encoded);
  if (!image) return std::nullopt;
  const auto drop_finest = [](TextureImage& of) {
    if (of.levels.size() > 1) of.levels.erase(of.levels.begin());
  };
  for (std::uint32_t i = 0; i < dropped_levels_; ++i) drop_finest(*image);
  texels_ += image->texel_count();
  images_.push_back(*std::move(image));
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
  if (!file.ok()) {
    outside_.push_back(name);
    return std::nullopt;
  }
  const auto bytes = files.read(*file, kMaxImageBytes);
  if (!bytes.ok()) {
    missing_.push_back(name);
    return std::nullopt;
  }
  slot->second = add(*bytes);
  if (!slot->second) unreadable_.push_back(name);
  return slot->second;
}

std::optional<LoadedImage> TextureImages::of_bytes(const std::string& key, std::span<const std::byte> encoded) {
  const auto [slot, is_new] = known_.try_emplace(key);
  if (!is_new) return slot->second;
  slot->second = add(encoded);
  if (!slot->second) unreadable_.push_back(key);
  return slot->second;
}

void TextureImages::report(SceneBuilder& builder) const {
  builder.note_files("missing texture images, plain colours used", missing_);
  builder.note_files("texture images that lie outside the folder of their input, not read, plain colours used",
                     outside_);
  builder.note_files("texture images that are neither JPEG nor PNG or are damaged, plain colours used", unreadable_);
  if (dropped_levels_ > 0)
    builder.note("finest levels of every texture image left out, to bound memory", dropped_levels_);
}

}  // namespace zc
