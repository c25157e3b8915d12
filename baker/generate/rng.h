// SPDX-License-Identifier: GPL-3.0-or-later
// The generator's only source of chance: splitmix64 (Steele, Lea & Flood 2014). The standard distributions differ
// between libraries, so ranges are drawn by hand: the same seed yields the same city everywhere.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace zc::generate {

class Rng {
 public:
  explicit Rng(std::uint64_t seed) : state_(seed) {}

  // An independent stream for one place of the city: what one block draws never shifts another block.
  Rng(std::uint64_t seed, std::uint64_t purpose, int i, int j) : state_(seed) {
    for (const std::uint64_t word : {purpose, static_cast<std::uint64_t>(i), static_cast<std::uint64_t>(j)}) {
      state_ = next() ^ (word * 0xD1342543DE82EF95ULL);
    }
  }

  std::uint64_t next() {
    state_ += 0x9E3779B97F4A7C15ULL;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31U);
  }

  double unit() { return static_cast<double>(next() >> 11U) * 0x1.0p-53; }  // [0, 1)
  double range(double low, double high) { return low + (high - low) * unit(); }
  // Whole quarter metres: layouts stay on round coordinates.
  double quarters(double low, double high) { return static_cast<double>(static_cast<long>(range(low, high) * 4)) / 4; }
  int below(int count) { return static_cast<int>(next() % static_cast<std::uint64_t>(count)); }
  bool chance(double probability) { return unit() < probability; }

  template <class T, std::size_t N>
  const T& pick(const T (&choices)[N]) {
    return choices[static_cast<std::size_t>(below(static_cast<int>(N)))];
  }
  template <class T>
  const T& pick(std::span<const T> choices) {
    return choices[static_cast<std::size_t>(below(static_cast<int>(choices.size())))];
  }

 private:
  std::uint64_t state_;
};

}  // namespace zc::generate
