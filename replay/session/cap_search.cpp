// SPDX-License-Identifier: Apache-2.0
#include "replay/session/cap_search.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace zc {
namespace {

constexpr std::uint64_t kResolution = 32;  // one part of so many
constexpr std::uint64_t kLeastStepBytes = 4096;

// Measures each cap once, whichever fraction asks.
class Caps {
 public:
  explicit Caps(const MeasureCap& measure) : measure_(measure) {}

  Result<double> reached(std::uint64_t cap) {
    const auto known = reached_.find(cap);
    if (known != reached_.end()) return known->second;
    ZC_ASSIGN(const double reached, measure_(cap));
    reached_.emplace(cap, reached);
    return reached;
  }

  // The smallest measured cap that does, and the largest below it.
  struct Bounds {
    std::optional<std::uint64_t> low, high;
  };
  [[nodiscard]] Bounds bounds(double fraction) const {
    Bounds found;
    for (const auto& [cap, reached] : reached_) {
      if (reached >= fraction) {
        found.high = cap;
        break;
      }
      found.low = cap;
    }
    return found;
  }

 private:
  const MeasureCap& measure_;
  std::map<std::uint64_t, double> reached_;
};

}  // namespace

Result<std::vector<CapNeed>> find_caps(std::span<const double> fractions, std::uint64_t smallest_bytes,
                                       std::uint64_t largest_bytes, const MeasureCap& measure) {
  std::vector<CapNeed> needs;
  if (fractions.empty()) return needs;
  Caps caps(measure);
  // Up in steps that double, so that little of the search is at caps far above what is needed.
  const double most = std::ranges::max(fractions);
  std::uint64_t cap = smallest_bytes;
  for (;;) {
    ZC_ASSIGN(const double reached, caps.reached(cap));
    if (reached >= most || cap >= largest_bytes) break;
    cap = cap > largest_bytes / 2 ? largest_bytes : 2 * cap;
  }
  for (const double fraction : fractions) {
    CapNeed need{fraction, std::nullopt, 0};
    Caps::Bounds in = caps.bounds(fraction);
    while (in.low && in.high && *in.high - *in.low > std::max(*in.low / kResolution, kLeastStepBytes)) {
      const double middle = std::sqrt(static_cast<double>(*in.low) * static_cast<double>(*in.high));
      const auto next = std::clamp(static_cast<std::uint64_t>(middle), *in.low + 1, *in.high - 1);
      ZC_TRY(caps.reached(next));
      in = caps.bounds(fraction);
    }
    need.cap_bytes = in.high;
    ZC_ASSIGN(need.reached, caps.reached(in.high.value_or(cap)));
    needs.push_back(need);
  }
  return needs;
}

}  // namespace zc
