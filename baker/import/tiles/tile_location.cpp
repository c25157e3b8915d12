// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/tiles/tile_location.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

#include "baker/import/shared/json_text.h"

namespace zc {
namespace {

using nlohmann::json;

// Distances from the earth's centre at which cities lie. A projected northing can be as long, but never far above 0.
constexpr double kNearestM = 6.3e6;
constexpr double kFarthestM = 6.45e6;
constexpr double kHighestM = 2e4;
// Regions wider than this say nothing of where the city is.
constexpr double kWideRegionRad = 0.1;

bool is_geocentric(const glm::dvec3& center) {
  const double distance = glm::length(center);
  return distance > kNearestM && distance < kFarthestM && std::abs(center.z) > kHighestM;
}

}  // namespace

TileVolume read_volume(const json& volume) {
  TileVolume read;
  if (const json* member = find_member(volume, "region"); member != nullptr) {
    const auto region = as_numbers(*member, 6);
    read.kind = region ? TileVolume::Kind::kRegion : TileVolume::Kind::kDamagedRegion;
    if (region) std::copy(region->begin(), region->end(), read.numbers.begin());
    return read;
  }
  for (const auto& [key, count] : {std::pair{"sphere", std::size_t{4}}, {"box", std::size_t{12}}}) {
    const json* member = find_member(volume, key);
    const auto numbers = member != nullptr ? as_numbers(*member, count) : std::nullopt;
    if (!numbers) continue;
    read.kind = TileVolume::Kind::kBox;
    std::copy_n(numbers->begin(), count == 4 ? 3 : 12, read.numbers.begin());
  }
  return read;
}

TileVolume part_of(const TileVolume& volume, const TileAddress& tile, std::uint32_t branching) {
  TileVolume part = volume;
  const double cells = std::ldexp(1.0, static_cast<int>(tile.level));
  const std::array<std::uint32_t, 3> at = {tile.x, tile.y, tile.z};
  for (std::size_t axis = 0; axis < (branching == 8 ? 3U : 2U); ++axis) {
    if (volume.kind == TileVolume::Kind::kRegion) {
      const std::size_t low = axis == 2 ? 4 : axis;
      const std::size_t high = axis == 2 ? 5 : axis + 2;
      double width = volume.numbers[high] - volume.numbers[low];
      if (axis == 0 && width < 0) width += 2 * std::numbers::pi;  // across 180°
      part.numbers[low] = volume.numbers[low] + width * at[axis] / cells;
      part.numbers[high] = volume.numbers[low] + width * (at[axis] + 1.0) / cells;
    } else if (volume.kind == TileVolume::Kind::kBox) {
      const double middle = (2.0 * at[axis] + 1) / cells - 1;
      for (std::size_t i = 0; i < 3; ++i) {
        part.numbers[i] += volume.numbers[3 + 3 * axis + i] * middle;
        part.numbers[3 + 3 * axis + i] /= cells;
      }
    }
  }
  return part;
}

Status TileLocation::see(const TileVolume& volume, const glm::dmat4& transform) {
  if (origin_ || volume.kind == TileVolume::Kind::kNone) return {};
  const auto& n = volume.numbers;
  if (volume.kind == TileVolume::Kind::kBox) {
    const glm::dvec3 center(transform * glm::dvec4(n[0], n[1], n[2], 1));
    if (is_geocentric(center)) origin_ = geodetic_of(center);
    return {};
  }
  if (volume.kind == TileVolume::Kind::kDamagedRegion)
    return Error{ErrorCode::kFormat, "has a tile with a region that is not six numbers"};
  const auto& [west, south, east, north] = std::array{n[0], n[1], n[2], n[3]};
  constexpr double kQuarter = 1.571;  // of a turn, a little more for rounding
  if (std::abs(south) > kQuarter || std::abs(north) > kQuarter || std::abs(west) > 2 * kQuarter ||
      std::abs(east) > 2 * kQuarter)
    return Error{ErrorCode::kFormat,
                 "has a tile with a region that is not on the earth, expected west, south, east and north in radians"};
  const double width = east < west ? east - west + 2 * std::numbers::pi : east - west;  // may cross 180°
  const Geodetic center{glm::degrees(west + width / 2), glm::degrees((south + north) / 2), (n[4] + n[5]) / 2};
  const bool is_wide = width > kWideRegionRad || north - south > kWideRegionRad;
  if (!is_wide)
    origin_ = center;
  else if (!wide_origin_)
    wide_origin_ = center;
  return {};
}

void TileLocation::see(const glm::dmat4& place) {
  if (!origin() && is_geocentric(glm::dvec3(place[3]))) origin_ = geodetic_of(glm::dvec3(place[3]));
}

}  // namespace zc
