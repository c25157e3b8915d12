// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/scene/texture_image.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

namespace zc {
namespace {

constexpr std::size_t kSrgbSteps = std::size_t{1} << 14U;

const std::array<float, 256>& linear_table() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> values{};
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = srgb_to_linear(static_cast<float>(i) / 255);
    return values;
  }();
  return table;
}

const std::array<std::uint8_t, kSrgbSteps + 1>& srgb_table() {
  static const std::array<std::uint8_t, kSrgbSteps + 1> table = [] {
    std::array<std::uint8_t, kSrgbSteps + 1> values{};
    for (std::size_t i = 0; i <= kSrgbSteps; ++i) {
      const float v = static_cast<float>(i) / kSrgbSteps;
      const float s = v <= 0.0031308F ? 12.92F * v : 1.055F * std::pow(v, 1 / 2.4F) - 0.055F;
      values[i] = static_cast<std::uint8_t>(s * 255 + 0.5F);
    }
    return values;
  }();
  return table;
}

using Texel = std::array<std::uint8_t, 3>;

glm::vec3 linear(const Texel& t) {
  const auto& table = linear_table();
  return {table[t[0]], table[t[1]], table[t[2]]};
}

Texel srgb(const glm::vec3& c) { return {linear_to_srgb8(c.r), linear_to_srgb8(c.g), linear_to_srgb8(c.b)}; }

// Every texel of the half covers two by two; the last of an odd row or column is taken twice.
TextureImage::Level halved(const TextureImage::Level& from) {
  TextureImage::Level to;
  to.width = (from.width + 1) / 2;
  to.height = (from.height + 1) / 2;
  to.texels.resize(std::size_t{to.width} * to.height);
  const auto& table = linear_table();
  for (std::uint32_t y = 0; y < to.height; ++y) {
    const Texel* low = from.texels.data() + std::size_t{2 * y} * from.width;
    const Texel* high = from.texels.data() + std::size_t{std::min(2 * y + 1, from.height - 1)} * from.width;
    for (std::uint32_t x = 0; x < to.width; ++x) {
      const std::uint32_t left = 2 * x;
      const std::uint32_t right = std::min(2 * x + 1, from.width - 1);
      Texel& out = to.texels[std::size_t{y} * to.width + x];
      for (std::size_t c = 0; c < 3; ++c)
        out[c] = linear_to_srgb8(
            (table[low[left][c]] + table[low[right][c]] + table[high[left][c]] + table[high[right][c]]) / 4);
    }
  }
  return to;
}

std::int64_t wrapped(std::int64_t i, std::int64_t size, TextureWrap wrap) {
  if (wrap == TextureWrap::kClamp) return std::clamp<std::int64_t>(i, 0, size - 1);
  const std::int64_t period = wrap == TextureWrap::kMirror ? 2 * size : size;
  std::int64_t at = i % period;
  if (at < 0) at += period;
  return at < size ? at : period - 1 - at;
}

// Exact sums: alpha per value and channel, linearised afterwards. An image that is all transparent counts as opaque.
glm::vec3 mean_of(std::span<const std::uint8_t> pixels, std::size_t channels) {
  std::array<std::array<std::uint64_t, 256>, 3> weight{};
  const bool grey = channels <= 2;
  const bool has_alpha = channels % 2 == 0;
  std::uint64_t total = 0;
  for (const bool use_alpha : {has_alpha, false}) {
    for (std::size_t at = 0; at + channels <= pixels.size(); at += channels) {
      const std::uint64_t alpha = use_alpha ? pixels[at + channels - 1] : 255U;
      for (std::size_t c = 0; c < 3; ++c) weight[c][pixels[at + (grey ? 0 : c)]] += alpha;
      total += alpha;
    }
    if (total > 0) break;
  }
  glm::vec3 mean(0);
  for (int c = 0; c < 3; ++c) {
    double sum = 0;
    for (std::size_t v = 0; v < 256; ++v)
      sum += static_cast<double>(weight[static_cast<std::size_t>(c)][v]) * linear_table()[v];
    mean[c] = static_cast<float>(sum / static_cast<double>(total));
  }
  return mean;
}

}  // namespace

float srgb_to_linear(float value) {
  return value <= 0.04045F ? value / 12.92F : std::pow((value + 0.055F) / 1.055F, 2.4F);
}

std::uint8_t linear_to_srgb8(float value) {
  const float within = value > 0 ? std::min(value, 1.0F) : 0;  // no number: 0
  return srgb_table()[static_cast<std::size_t>(within * kSrgbSteps + 0.5F)];
}

float srgb8_to_linear(std::uint8_t value) { return linear_table()[value]; }

TextureImage make_texture_image(std::span<const std::uint8_t> pixels, std::uint32_t width, std::uint32_t height,
                                std::uint32_t channels) {
  TextureImage image;
  image.mean = mean_of(pixels, channels);
  TextureImage::Level level{width, height, {}};
  level.texels.resize(std::size_t{width} * height);
  for (std::size_t i = 0; i < level.texels.size(); ++i) {
    const std::uint8_t* p = pixels.data() + i * channels;
    Texel& out = level.texels[i];
    for (std::size_t c = 0; c < 3; ++c) out[c] = p[channels <= 2 ? 0 : c];
    if (channels % 2 != 0 || p[channels - 1] == 255) continue;
    out = srgb(glm::mix(image.mean, linear(out), static_cast<float>(p[channels - 1]) / 255));
  }
  while (std::max(level.width, level.height) > kTextureImageMaxSize) level = halved(level);
  image.levels.push_back(std::move(level));
  while (image.levels.back().texels.size() > 1) image.levels.push_back(halved(image.levels.back()));
  return image;
}

glm::vec3 TextureImage::sample(glm::vec2 uv, std::size_t level, TextureWrap wrap_u, TextureWrap wrap_v) const {
  const Level& l = levels[std::min(level, levels.size() - 1)];
  const auto place = [](float t, std::uint32_t size) {
    // Beyond this a float separates no texels; no number has no place at all.
    const double at = static_cast<double>(t) * size - 0.5;
    return std::isnan(at) ? 0.0 : std::clamp(at, -1e9, 1e9);
  };
  const double x = place(uv.x, l.width);
  const double y = place(uv.y, l.height);
  const auto left = static_cast<std::int64_t>(std::floor(x));
  const auto top = static_cast<std::int64_t>(std::floor(y));
  const auto texel = [&](std::int64_t i, std::int64_t j) {
    return linear(
        l.texels[static_cast<std::size_t>(wrapped(j, l.height, wrap_v) * l.width + wrapped(i, l.width, wrap_u))]);
  };
  const auto part_x = static_cast<float>(x - static_cast<double>(left));
  const auto part_y = static_cast<float>(y - static_cast<double>(top));
  return glm::mix(glm::mix(texel(left, top), texel(left + 1, top), part_x),
                  glm::mix(texel(left, top + 1), texel(left + 1, top + 1), part_x), part_y);
}

std::size_t TextureImage::texel_count() const {
  std::size_t count = 0;
  for (const Level& level : levels) count += level.texels.size();
  return count;
}

}  // namespace zc
