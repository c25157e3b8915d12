// SPDX-License-Identifier: GPL-3.0-or-later
// How much a packed file may become. City models shrink to a tenth or a thirtieth, rarely to a hundredth; what shrinks
// further is made to fill the memory of whoever unpacks it. Thread-safe: no state.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>

#include "base/result.h"

namespace zc {

inline constexpr std::uint64_t kMaxUnpackRatio = 200;
inline constexpr std::uint64_t kAlwaysUnpackedBytes = std::uint64_t{16} << 20U;

inline std::uint64_t unpack_limit(std::uint64_t packed_bytes) {
  return std::max(kAlwaysUnpackedBytes, kMaxUnpackRatio * packed_bytes);
}

inline Error unpacks_too_far(std::uint64_t packed_bytes, const std::string& path) {
  return {ErrorCode::kUnsupported,
          "unpacks to more than " + std::to_string(unpack_limit(packed_bytes)) + " bytes, expected no more than " +
              std::to_string(kMaxUnpackRatio) + " times its " + std::to_string(packed_bytes) +
              "; if it is a city model, unpack it and bake what is in it",
          path};
}

}  // namespace zc
