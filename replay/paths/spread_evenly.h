// SPDX-License-Identifier: Apache-2.0
// A few of many. Pure.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace zc {

// At most `limit` of `count` places, the first and the last among them, in ascending order.
inline std::vector<std::size_t> spread_evenly(std::size_t count, std::size_t limit) {
  std::vector<std::size_t> out;
  const std::size_t chosen = std::min(count, limit);
  for (std::size_t i = 0; i < chosen; ++i) out.push_back(chosen == 1 ? 0 : i * (count - 1) / (chosen - 1));
  return out;
}

}  // namespace zc
