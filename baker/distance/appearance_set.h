// SPDX-License-Identifier: GPL-3.0-or-later
// A set of appearances (measure.h: appearance_classes). The first 64, which are all that most cities have, are the bits
// of a word; only others need memory. Thread-safe: a plain value.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace zc {

class AppearanceSet {
 public:
  void add(std::uint16_t appearance) {
    if (appearance < kBits) {
      first_ |= std::uint64_t{1} << appearance;
    } else if (!has(appearance)) {
      others_.push_back(appearance);
    }
  }
  [[nodiscard]] bool has(std::uint16_t appearance) const {
    if (appearance < kBits) return (first_ >> appearance & 1U) != 0;
    return std::ranges::find(others_, appearance) != others_.end();
  }
  // Those below 64.
  [[nodiscard]] std::uint64_t first_bits() const { return first_; }

 private:
  static constexpr std::uint16_t kBits = 64;

  std::uint64_t first_ = 0;
  std::vector<std::uint16_t> others_;
};

}  // namespace zc
