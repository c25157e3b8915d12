// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/shared/texture_images.h"

#include "baker/import/images/decode_image.h"
#include "baker/import/shared/scene_builder.h"

namespace zc {
namespace {

constexpr std::uint64_t kMaxImageBytes = 256U << 20U;
// Of all images together, 3 bytes each: beyond it they all lose their finest level.
constexpr std::uint64_t kMaxTexels = 1U << 28U;

}  // namespace

std::optional<LoadedImage> TextureImages::add(const std::string& name, std::span<const std::byte> encoded) {
  const Result<DecodedImage> decoded = decode_image(encoded);
  if (!decoded) {
    unreadable_.push_back(name + " (" + decoded.error().message + ")");
    return std::nullopt;
  }
  TextureImage image = make_texture_image(decoded->pixels, decoded->width, decoded->height, decoded->channels);
  const auto drop_finest = [](TextureImage& of) {
    if (of.levels.size() > 1) of.levels.erase(of.levels.begin());
  };
  for (std::uint32_t i = 0; i < dropped_levels_; ++i) drop_finest(image);
  texels_ += image.texel_count();
  images_.push_back(std::move(image));
  masks_.emplace_back();
  if (decoded->channels % 2 == 0) {
    auto mask = std::make_unique<AlphaMask>(decoded->pixels, decoded->width, decoded->height, decoded->channels);
    if (mask->share_at_least(1) < 1) masks_.back() = std::move(mask);
  }
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
  slot->second = add(name, *bytes);
  return slot->second;
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
