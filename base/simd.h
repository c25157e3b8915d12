// SPDX-License-Identifier: Apache-2.0
// Vector registers: types on whose lanes operators work, and what operators cannot say. GCC and Clang have them on
// every processor; for another compiler this is the file to change. Thread-safe: plain values.
#pragma once

#include <cstdint>

namespace zc {

using Float4 = float __attribute__((vector_size(16)));
using Int4 = std::int32_t __attribute__((vector_size(16)));
using Short8 = std::int16_t __attribute__((vector_size(16)));
using UnsignedShort8 = std::uint16_t __attribute__((vector_size(16)));
using Short4 = std::int16_t __attribute__((vector_size(8)));

// Lane by lane, as a cast does.
inline Float4 to_floats(Int4 lanes) { return __builtin_convertvector(lanes, Float4); }
inline Int4 to_ints(Float4 lanes) { return __builtin_convertvector(lanes, Int4); }
inline Int4 to_ints(Short4 lanes) { return __builtin_convertvector(lanes, Int4); }

// The lanes of those numbers, in that order.
template <int... kLanes>
Short8 take_lanes(Short8 lanes) {
  return __builtin_shufflevector(lanes, lanes, kLanes...);
}

}  // namespace zc
