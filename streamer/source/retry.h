// SPDX-License-Identifier: Apache-2.0
// How long to wait before the same is tried again: 0.1, 0.4, 1.6 and then every 10 seconds, or longer where the error
// says so. Thread-safe: no state.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <thread>

#include "base/result.h"

namespace zc {

inline constexpr double kLongestRetryDelay_s = 10;

// After so many failures in a row, at least one.
inline double retry_delay_s(std::uint32_t failures) {
  constexpr std::array<double, 3> kDelays = {0.1, 0.4, 1.6};
  return failures <= kDelays.size() ? kDelays[failures - 1] : kLongestRetryDelay_s;
}

// f(), a Result, again after the short delays as long as it fails with kTransient. For callers that have nothing else
// to do: sleeps.
template <class F>
auto with_retries(F&& f) -> decltype(f()) {
  for (std::uint32_t failures = 1;; ++failures) {
    auto result = f();
    if (result.ok() || result.error().code != ErrorCode::kTransient) return result;
    const double delay_s = std::max(retry_delay_s(failures), result.error().retry_after_s);
    if (retry_delay_s(failures) >= kLongestRetryDelay_s || delay_s > kLongestRetryDelay_s) return result;
    std::this_thread::sleep_for(std::chrono::duration<double>(delay_s));
  }
}

}  // namespace zc
