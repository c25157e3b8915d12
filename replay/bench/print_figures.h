// SPDX-License-Identifier: Apache-2.0
// What the benchmarks share in printing their figures.
#pragma once

#include <algorithm>
#include <array>
#include <cstdio>
#include <string>
#include <vector>

namespace zc::bench {

// printf into a string; longer ones are cut.
template <class... Values>
std::string format(const char* pattern, Values... values) {
  std::array<char, 512> line{};
  const int length = std::snprintf(line.data(), line.size(), pattern, values...);
  return {line.data(), std::min(static_cast<std::size_t>(std::max(length, 0)), line.size() - 1)};
}

// At least one value.
inline double median(std::vector<double> values) {
  std::ranges::sort(values);
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : (values[half - 1] + values[half]) / 2;
}

}  // namespace zc::bench
