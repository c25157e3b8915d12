// SPDX-License-Identifier: Apache-2.0
#include "streamer/latency_samples.h"

#include <algorithm>
#include <cmath>

namespace zc {

void LatencySamples::add(double ms) {
  max_ms_ = std::max(max_ms_, ms);
  if (seen_++ % stride_ != 0) return;
  if (samples_ms_.size() == kCapacity) {
    for (std::size_t i = 0; i < kCapacity / 2; ++i) samples_ms_[i] = samples_ms_[2 * i];
    samples_ms_.resize(kCapacity / 2);
    stride_ *= 2;
    if ((seen_ - 1) % stride_ != 0) return;
  }
  samples_ms_.push_back(static_cast<float>(ms));
}

LatencySummary LatencySamples::summary() const {
  LatencySummary out;
  out.samples = seen_;
  out.max_ms = max_ms_;
  if (samples_ms_.empty()) return out;
  std::vector<float> sorted = samples_ms_;
  std::sort(sorted.begin(), sorted.end());
  const auto rank = [&](double share) {
    const auto at = static_cast<std::size_t>(std::ceil(share * static_cast<double>(sorted.size())));
    const double ms = static_cast<double>(sorted[std::clamp<std::size_t>(at, 1, sorted.size()) - 1]);
    return std::min(ms, max_ms_);  // samples are floats: one may have been rounded up
  };
  out.p50_ms = rank(0.50);
  out.p95_ms = rank(0.95);
  out.p99_ms = rank(0.99);
  return out;
}

}  // namespace zc
