// SPDX-License-Identifier: Apache-2.0
#include "replay/bench/clock_warmer.h"

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <utility>

#include "replay/bench/engines/gpu_engine.h"
#include "replay/bench/engines/stopwatch.h"
#include "spirv/bench.h"

namespace zc::bench {
namespace {

constexpr std::uint32_t kGroups = 8192;
constexpr std::array<std::uint32_t, 1> kRounds = {16384};
constexpr double kShortMs = 100;
constexpr double kSteadyMs = 2000;  // without a faster run
constexpr double kLongMs = 6000;
constexpr double kFaster = 0.99;

}  // namespace

Result<ClockWarmer> ClockWarmer::create(Device& device) {
  ClockWarmer warmer;
  if (device.is_cpu()) return warmer;
  constexpr std::array<std::byte, 4> zero = {};
  ZC_ASSIGN(warmer.sums_, make_filled_buffer(device, zero));
  KernelOptions options;
  options.spirv = shader::spin();
  options.buffers = 1;
  options.push_bytes = sizeof(kRounds);
  ZC_ASSIGN(warmer.kernel_, ComputeKernel::create(device, options));
  ZC_TRY(warmer.kernel_->bind(0, warmer.sums_));
  return warmer;
}

Status ClockWarmer::warm() {
  if (kernel_ == nullptr) return {};
  const Stopwatch all;
  Stopwatch since_faster;
  double best_ms = std::numeric_limits<double>::infinity();
  do {
    ZC_ASSIGN(const double ms, spin());
    if (ms < kFaster * best_ms) since_faster = Stopwatch();
    best_ms = std::min(best_ms, ms);
  } while (all.ms() < (warm_ ? kShortMs : kLongMs) && (warm_ || since_faster.ms() < kSteadyMs));
  warm_ = true;
  return {};
}

Result<double> ClockWarmer::spin() {
  ZC_ASSIGN(const KernelTimes times, kernel_->run(std::as_bytes(std::span(kRounds)), kGroups, 1));
  return times.min_ms;
}

}  // namespace zc::bench
