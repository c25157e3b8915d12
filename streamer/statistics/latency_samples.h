// SPDX-License-Identifier: Apache-2.0
// Percentiles of any number of durations in fixed memory: counts in buckets that grow by a 32nd of their octave, from a
// 16th of a microsecond, below which all is 0, to an hour and more; a percentile is its bucket's upper edge, at most
// 3.2 % too large. The largest is exact. Threads: one · units: milliseconds.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "streamer/statistics/statistics.h"

namespace zc {

class LatencySamples {
 public:
  void add(double ms);
  // Nearest rank.
  [[nodiscard]] LatencySummary summary() const;

 private:
  static constexpr std::size_t kPerOctave = 32;
  static constexpr std::size_t kOctaves = 36;

  std::array<std::uint32_t, kPerOctave* kOctaves> counts_ = {};
  std::uint64_t samples_ = 0;
  double max_ms_ = 0;
};

}  // namespace zc
