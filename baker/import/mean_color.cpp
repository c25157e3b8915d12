// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/mean_color.h"

#include <array>
#include <cmath>
#include <limits>
#include <memory>

#include "baker/import/scene_builder.h"
#include "base/file.h"

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

}  // namespace

float srgb_to_linear(float value) {
  return value <= 0.04045F ? value / 12.92F : std::pow((value + 0.055F) / 1.055F, 2.4F);
}

std::optional<glm::vec3> mean_linear_color(std::span<const std::byte> encoded) {
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

  // Exact sums: alpha per value and channel, linearised afterwards.
  std::array<std::array<std::uint64_t, 256>, 3> weight{};
  const auto step = static_cast<std::size_t>(channels);
  const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  const bool grey = channels <= 2;
  const bool has_alpha = channels == 2 || channels == 4;
  std::uint64_t total = 0;
  for (const bool use_alpha : {has_alpha, false}) {  // an image that is all transparent counts as opaque
    for (std::size_t i = 0; i < count; ++i) {
      const stbi_uc* p = pixels.get() + i * step;
      const std::uint64_t alpha = use_alpha ? p[step - 1] : 255U;
      for (std::size_t c = 0; c < 3; ++c) weight[c][p[grey ? 0 : c]] += alpha;
      total += alpha;
    }
    if (total > 0) break;
  }
  glm::vec3 mean(0);
  for (int c = 0; c < 3; ++c) {
    double sum = 0;
    for (std::size_t v = 0; v < 256; ++v)
      sum += static_cast<double>(weight[static_cast<std::size_t>(c)][v]) * srgb_to_linear(static_cast<float>(v) / 255);
    mean[c] = static_cast<float>(sum / static_cast<double>(total));
  }
  return mean;
}

void MeanColors::Tally::add(const std::string& name) {
  if (count++ == 0) first = name;
}

std::optional<glm::vec3> MeanColors::of_file(const std::filesystem::path& folder, const std::string& name) {
  if (!enabled_) return std::nullopt;
  const std::filesystem::path file = folder / name;
  const auto [slot, is_new] = known_.try_emplace(file.string());
  if (!is_new) return slot->second;
  const auto bytes = read_file(file, kMaxImageBytes);
  if (!bytes.ok()) {
    missing_.add(name);
    return std::nullopt;
  }
  slot->second = mean_linear_color(*bytes);
  if (!slot->second) unreadable_.add(name);
  return slot->second;
}

std::optional<glm::vec3> MeanColors::of_bytes(const std::string& key, std::span<const std::byte> encoded) {
  if (!enabled_) return std::nullopt;
  const auto [slot, is_new] = known_.try_emplace(key);
  if (!is_new) return slot->second;
  slot->second = mean_linear_color(encoded);
  if (!slot->second) unreadable_.add(key);
  return slot->second;
}

void MeanColors::report(SceneBuilder& builder) const {
  if (missing_.count > 0)
    builder.note("missing texture images (first: " + missing_.first + "), plain colours used", missing_.count);
  if (unreadable_.count > 0)
    builder.note("texture images that are neither JPEG nor PNG or are damaged (first: " + unreadable_.first +
                     "), plain colours used",
                 unreadable_.count);
}

}  // namespace zc
