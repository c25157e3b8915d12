// SPDX-License-Identifier: GPL-3.0-or-later
// Which axis of a model points up. Thread-safe: no state.
#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>

namespace zc {

enum class UpAxis : std::uint8_t { kX, kY, kZ };

// Of formats that have no rule (OBJ, PLY): as in most survey data.
inline constexpr UpAxis kUpWithoutRule = UpAxis::kZ;

// Turns the axis to z. Columns.
inline glm::dmat4 upright(UpAxis up) {
  switch (up) {
    case UpAxis::kX:
      return {{0, 0, 1, 0}, {0, 1, 0, 0}, {-1, 0, 0, 0}, {0, 0, 0, 1}};
    case UpAxis::kY:
      return {{1, 0, 0, 0}, {0, 0, 1, 0}, {0, -1, 0, 0}, {0, 0, 0, 1}};
    case UpAxis::kZ:
      break;
  }
  return glm::dmat4(1);
}

}  // namespace zc
