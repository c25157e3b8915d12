// SPDX-License-Identifier: Apache-2.0
// Where the sun stands, to a hundredth of a degree, so that a replay can compare it with the bake's. Units: degrees.
// Thread-safe: plain values. Untrusted input: unpack() refuses what pack() does not give.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>

namespace zc {

struct SunAngles {
  float azimuth_deg = 0;    // clockwise from north (+y)
  float elevation_deg = 0;  // 0..90 in a world

  // As WorldHeader::sun stores it: never 0.
  [[nodiscard]] std::uint32_t pack() const {
    const long azimuth = std::lround(azimuth_deg * 100.0);
    const long elevation = std::lround(elevation_deg * 100.0);
    return kSet | static_cast<std::uint32_t>((azimuth % kTurn + kTurn) % kTurn) |
           (static_cast<std::uint32_t>(elevation) & kElevationBits) << 16U;
  }
  // Nothing when `packed` is not what pack() gives for a sun above the horizon.
  static std::optional<SunAngles> unpack(std::uint32_t packed) {
    const std::uint32_t azimuth = packed & 0xFFFFU;
    const std::uint32_t elevation = packed >> 16U & kElevationBits;
    if ((packed & kSet) == 0 || (packed & kUnused) != 0 || azimuth >= kTurn || elevation > kZenith) return std::nullopt;
    return SunAngles{static_cast<float>(azimuth) / 100, static_cast<float>(elevation) / 100};
  }

 private:
  static constexpr std::uint32_t kSet = 1U << 31U;
  static constexpr std::uint32_t kUnused = 1U << 30U;
  static constexpr std::uint32_t kElevationBits = (1U << 14U) - 1;
  static constexpr long kTurn = 36'000;
  static constexpr std::uint32_t kZenith = 9'000;
};

}  // namespace zc
