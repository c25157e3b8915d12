// SPDX-License-Identifier: Apache-2.0
// What the kernel says this process holds. Linux. Thread-safe: no state.
#pragma once

#include <cstdint>

namespace zc {

std::uint64_t resident_set_bytes();       // now
std::uint64_t peak_resident_set_bytes();  // since the start, or since the last reset
void reset_peak_resident_set();           // where the kernel allows it

}  // namespace zc
