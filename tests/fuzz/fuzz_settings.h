// SPDX-License-Identifier: Apache-2.0
// How much is damaged, and from which seed on: ZONECAST_FUZZ_TRIES and ZONECAST_FUZZ_SEED, so that runs by hand may go
// on longer, and elsewhere. Thread-safe: no state.
#pragma once

#include <cstdint>
#include <cstdlib>

namespace zc::test {

inline std::uint64_t fuzz_setting(const char* variable, std::uint64_t fallback) {
  const char* text = std::getenv(variable);
  return text == nullptr ? fallback : std::strtoull(text, nullptr, 10);
}
inline std::uint64_t fuzz_seed() { return fuzz_setting("ZONECAST_FUZZ_SEED", 1); }
inline std::uint64_t fuzz_tries() { return fuzz_setting("ZONECAST_FUZZ_TRIES", 10000); }

}  // namespace zc::test
