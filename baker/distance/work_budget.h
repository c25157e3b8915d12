// SPDX-License-Identifier: GPL-3.0-or-later
// Work of geometric searches, counted in boxes and triangles visited and never in time: what stops when so much is
// done stops at the same place on every machine. Not thread-safe: one per task.
#pragma once

#include <cstdint>

namespace zc {

struct Work {
  std::uint64_t limit = UINT64_MAX;
  std::uint64_t done = 0;

  [[nodiscard]] bool is_spent() const { return done >= limit; }
};

}  // namespace zc
