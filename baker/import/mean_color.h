// SPDX-License-Identifier: GPL-3.0-or-later
// Mean linear colour of texture images (JPEG, PNG), each decoded once. An image that is missing or does not decode is
// no error: it is counted and the caller uses its plain colour.
// Owns the cache. Untrusted input. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <span>
#include <string>

namespace zc {

class SceneBuilder;

float srgb_to_linear(float value);

// Weighted by alpha where the image has any. Nothing when the bytes are no image.
std::optional<glm::vec3> mean_linear_color(std::span<const std::byte> encoded);

class MeanColors {
 public:
  explicit MeanColors(bool enabled) : enabled_(enabled) {}

  // `name` is how the model calls the image, `folder` where the model lies.
  std::optional<glm::vec3> of_file(const std::filesystem::path& folder, const std::string& name);
  // `key` tells images within models apart.
  std::optional<glm::vec3> of_bytes(const std::string& key, std::span<const std::byte> encoded);
  void report(SceneBuilder& builder) const;

 private:
  struct Tally {
    std::uint64_t count = 0;
    std::string first;
    void add(const std::string& name);
  };
  bool enabled_;
  std::map<std::string, std::optional<glm::vec3>> known_;
  Tally missing_;
  Tally unreadable_;
};

}  // namespace zc
