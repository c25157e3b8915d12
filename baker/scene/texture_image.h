// SPDX-License-Identifier: GPL-3.0-or-later
// A source texture as the bake keeps it: no larger than atlases can show, halved down to one texel.
// Owns its texels. Deterministic. Thread-safe for const use.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace zc {

float srgb_to_linear(float value);
// 0..255, to the nearest; 0 of what is no number.
std::uint8_t linear_to_srgb8(float value);
float srgb8_to_linear(std::uint8_t value);

enum class TextureWrap : std::uint8_t { kRepeat, kMirror, kClamp };

struct TextureImage {
  struct Level {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<std::array<std::uint8_t, 3>> texels;  // sRGB, rows from the top
  };
  std::vector<Level> levels;  // each half as large as the one before, the last of one texel
  glm::vec3 mean{0};          // linear, of the whole image at its full size

  // Linear colour at `uv` (texture coordinates, v downwards; any values), filtered over four texels of the level.
  [[nodiscard]] glm::vec3 sample(glm::vec2 uv, std::size_t level, TextureWrap wrap_u, TextureWrap wrap_v) const;
  [[nodiscard]] std::size_t texel_count() const;
};

// Halved until neither side is longer than this.
inline constexpr std::uint32_t kTextureImageMaxSize = 512;

// `pixels`: rows of `channels` bytes (1 grey, 2 grey and alpha, 3 sRGB, 4 sRGB and alpha) a pixel. What is
// transparent takes the mean colour, which is weighted by alpha. Sizes at least 1.
TextureImage make_texture_image(std::span<const std::uint8_t> pixels, std::uint32_t width, std::uint32_t height,
                                std::uint32_t channels);

}  // namespace zc
