// SPDX-License-Identifier: Apache-2.0
// Wall-clock milliseconds since it was made. Thread-safe: const.
#pragma once

#include <chrono>

namespace zc::bench {

class Stopwatch {
 public:
  [[nodiscard]] double ms() const {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace zc::bench
