// SPDX-License-Identifier: Apache-2.0
// What arrays take of the memory that a record promises for decoding. Units: bytes. Thread-safe: pure.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

namespace zc {

// The allocator has a head before each array, and gives large ones whole pages.
template <class T>
std::uint64_t array_scratch(std::uint64_t count) {
  constexpr std::uint64_t kHead = 32;
  constexpr std::uint64_t kLarge = 1 << 16U;
  constexpr std::uint64_t kPage = 1 << 12U;
  const std::uint64_t bytes = sizeof(T) * count;
  return bytes + (bytes < kLarge ? kHead : kPage + kHead);
}

inline std::uint32_t clamp_bytes(std::uint64_t bytes) {
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(bytes, std::numeric_limits<std::uint32_t>::max()));
}

}  // namespace zc
