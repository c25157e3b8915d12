// SPDX-License-Identifier: GPL-3.0-or-later
// The opaque part of a texture, as geometry: a page stores a surface or it does not, so leaves and wires are cut out of
// the cards that they are painted on. Owns its levels. Deterministic. Thread-safe for const use.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "baker/scene/texture_image.h"

namespace zc {

class AlphaMask {
 public:
  // pixels: rows of `channels` bytes a pixel, of which the last is alpha. Kept at 512 texels a side at most.
  AlphaMask(std::span<const std::uint8_t> pixels, std::uint32_t width, std::uint32_t height, std::uint32_t channels);

  // Corners of a piece, as shares of the triangle's own three.
  using Piece = std::array<glm::vec3, 3>;
  struct Triangle {
    std::array<glm::vec2, 3> uv;  // v downwards
  };
  struct Cut {
    std::vector<Piece> pieces;
    std::vector<std::uint32_t> of;  // per piece: which of the triangles; ascending
    bool is_whole = false;          // nothing is transparent: no pieces are made
  };

  // Where alpha is at least `cutoff` (0 to 1): along straight lines between the texels, at the finest level of the
  // image that gives no more than `most` pieces. Every level keeps as much area as the finest (after Castaño,
  // "Computing Alpha Mipmaps", 2010, which keeps the share of texels), so that thin wires do not vanish.
  [[nodiscard]] Cut cut(std::span<const Triangle> triangles, TextureWrap wrap_u, TextureWrap wrap_v, float cutoff,
                        std::size_t most) const;

  // Of the finest level.
  [[nodiscard]] double share_at_least(float cutoff) const;

 private:
  struct Level {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<std::uint8_t> alpha;
  };
  [[nodiscard]] double kept_share(std::size_t level, double limit) const;
  [[nodiscard]] double limit_of(std::size_t level, float cutoff) const;
  [[nodiscard]] bool cut_at(std::size_t level, std::span<const Triangle> triangles, TextureWrap wrap_u,
                            TextureWrap wrap_v, float cutoff, std::size_t most, Cut& out) const;

  std::vector<Level> levels_;  // each half as large as the one before
};

}  // namespace zc
