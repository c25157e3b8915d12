// SPDX-License-Identifier: GPL-3.0-or-later
// Texture images (decode_image.h) of the inputs, each decoded once. An image that is missing, does not decode or may
// not be read is no error: it is named in the notes and the caller uses its plain colour. Owns the images. Untrusted
// input. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "baker/import/images/alpha_mask.h"
#include "baker/import/images/decode_image.h"
#include "baker/import/shared/input_files.h"
#include "baker/scene/texture_image.h"
#include "base/result.h"

namespace zc {

class SceneBuilder;

struct LoadedImage {
  std::uint32_t index = 0;  // of Scene::images
  glm::vec3 mean{0};        // linear
};

class TextureImages {
 public:
  // `file` is where the image lies, or why it is not read (uri.h); `name` is how the model calls it.
  std::optional<LoadedImage> of_file(const Result<std::filesystem::path>& file, const std::string& name,
                                     const InputFiles& files = disk_files());
  // `key` separates images within models.
  std::optional<LoadedImage> of_bytes(const std::string& key, std::span<const std::byte> encoded);
  // Where an image that another format keeps apart says that a surface is opaque: its alpha, or how light it is where
  // it has none. Null when all of it is, and when it cannot be read.
  const AlphaMask* coverage_of_file(const Result<std::filesystem::path>& file, const std::string& name,
                                    const InputFiles& files);
  // Where the image is opaque; null when all of it is.
  [[nodiscard]] const AlphaMask* mask_of(std::uint32_t index) const { return masks_[index].get(); }
  void report(SceneBuilder& builder) const;
  [[nodiscard]] std::vector<TextureImage> take() { return std::move(images_); }

 private:
  std::optional<LoadedImage> add(const std::string& name, std::span<const std::byte> encoded);
  std::optional<DecodedImage> decoded(const std::string& name, std::span<const std::byte> encoded);
  std::optional<std::vector<std::byte>> bytes_of(const Result<std::filesystem::path>& file, const std::string& name,
                                                 const InputFiles& files);

  std::map<std::string, std::unique_ptr<AlphaMask>> coverages_;
  std::map<std::string, std::optional<LoadedImage>> known_;
  std::vector<TextureImage> images_;
  std::vector<std::unique_ptr<AlphaMask>> masks_;  // per image
  std::uint64_t texels_ = 0;
  std::uint32_t dropped_levels_ = 0;  // of every image, so that all fit
  std::vector<std::string> missing_;
  std::vector<std::string> outside_;
  std::vector<std::string> unreadable_;
};

}  // namespace zc
