// SPDX-License-Identifier: GPL-3.0-or-later
// Where a tileset is on the earth, from the volumes of its tiles. Units: metres, region in radians. Thread-safe: plain
// values.
#pragma once

#include <array>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "baker/geo/earth_frame.h"
#include "base/result.h"

namespace zc {

// A boundingVolume of 3D Tiles. A region says where it is without the tile's transform.
struct TileVolume {
  enum class Kind : std::uint8_t { kNone, kRegion, kBox, kDamagedRegion };
  Kind kind = Kind::kNone;
  // West, south, east, north, lowest, highest; or a centre and three half axes, of a sphere all zero.
  std::array<double, 12> numbers{};
};

TileVolume read_volume(const nlohmann::json& volume);

// Of a tile of an implicit tiling: `volume` cut in half in x and y, with `branching` 8 in z too, at every level.
struct TileAddress {
  std::uint32_t level = 0;
  std::uint32_t x = 0;
  std::uint32_t y = 0;
  std::uint32_t z = 0;
};
TileVolume part_of(const TileVolume& volume, const TileAddress& tile, std::uint32_t branching);

class TileLocation {
 public:
  // The first volume, from the root down, that lies in one place on the earth is where the tileset is. Fails on regions
  // that are none.
  Status see(const TileVolume& volume, const glm::dmat4& transform);
  // For tilesets whose volumes say nothing.
  void see(const glm::dmat4& place);
  [[nodiscard]] bool is_known() const { return origin_.has_value(); }
  // Nothing when the tileset is not geocentric.
  [[nodiscard]] const std::optional<Geodetic>& origin() const { return origin_ ? origin_ : wide_origin_; }

 private:
  std::optional<Geodetic> origin_;
  std::optional<Geodetic> wide_origin_;
};

}  // namespace zc
