// SPDX-License-Identifier: Apache-2.0
#include "streamer/statistics/latency_samples.h"

#include <algorithm>
#include <cmath>

namespace zc {
namespace {

constexpr double kShortest_ms = 1.0 / (16 * 1024);

}  // namespace

void LatencySamples::add(double ms) {
  max_ms_ = std::max(max_ms_, ms);
  ++samples_;
  std::size_t bucket = 0;
  if (ms > kShortest_ms) {
    int octave = 0;
    const double mantissa = std::frexp(ms / kShortest_ms, &octave);  // 0.5 to 1: exact, unlike a logarithm
    const auto part = static_cast<std::size_t>((mantissa - 0.5) * 2 * kPerOctave);
    bucket = std::min(1 + static_cast<std::size_t>(octave - 1) * kPerOctave + part, counts_.size() - 1);
  }
  ++counts_[bucket];
}

LatencySummary LatencySamples::summary() const {
  LatencySummary out;
  out.samples = samples_;
  out.max_ms = max_ms_;
  const auto rank = [&](double share) {
    const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(samples_)));
    std::uint64_t seen = 0;
    for (std::size_t b = 0; b < counts_.size(); ++b) {
      seen += counts_[b];
      if (seen < std::max<std::uint64_t>(wanted, 1)) continue;
      if (b + 1 == counts_.size()) break;  // the last one has no upper edge
      if (b == 0) return 0.0;
      const double edge = 1 + static_cast<double>((b - 1) % kPerOctave + 1) / kPerOctave;
      return std::min(std::ldexp(kShortest_ms * edge, static_cast<int>((b - 1) / kPerOctave)), max_ms_);
    }
    return max_ms_;
  };
  out.p50_ms = rank(0.50);
  out.p95_ms = rank(0.95);
  out.p99_ms = rank(0.99);
  return out;
}

}  // namespace zc
