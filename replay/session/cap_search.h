// SPDX-License-Identifier: Apache-2.0
// Which cap a path needs for which share of its frames at the wanted level. Searches among real replays without
// pictures, by bisection: what it finds was measured under that very cap. Units: bytes. Thread-safe: no state.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "base/result.h"

namespace zc {

struct CapNeed {
  double fraction = 0;                     // asked for
  std::optional<std::uint64_t> cap_bytes;  // the smallest one found; none: not even with room for everything
  double reached = 0;                      // under that cap, or under the largest
};

// The wanted level fraction of a replay under a cap.
using MeasureCap = std::function<Result<double>(std::uint64_t cap_bytes)>;

// A cap a thirty-second below what is found was measured too, and does not do; smaller ones may where more memory makes
// a frame worse, which a greedy selection does not rule out. smallest: under which the world opens; largest: with room
// for everything. The needs in the order of `fractions`.
Result<std::vector<CapNeed>> find_caps(std::span<const double> fractions, std::uint64_t smallest_bytes,
                                       std::uint64_t largest_bytes, const MeasureCap& measure);

}  // namespace zc
