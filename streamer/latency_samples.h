// SPDX-License-Identifier: Apache-2.0
// Percentiles of durations in fixed memory: exact up to kCapacity samples, then every second, fourth, … sample (the
// same ones in every run); the maximum is always exact. Threads: one · units: milliseconds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "streamer/statistics.h"

namespace zc {

class LatencySamples {
 public:
  static constexpr std::size_t kCapacity = 8192;

  LatencySamples() { samples_ms_.reserve(kCapacity); }
  void add(double ms);
  // Nearest rank.
  [[nodiscard]] LatencySummary summary() const;

 private:
  std::vector<float> samples_ms_;
  std::uint64_t stride_ = 1;
  std::uint64_t seen_ = 0;
  double max_ms_ = 0;
};

}  // namespace zc
