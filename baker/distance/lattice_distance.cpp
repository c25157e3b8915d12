// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/distance/lattice_distance.h"

#include <algorithm>
#include <cmath>

namespace zc {

LatticeVector difference(const LatticePoint& to, const LatticePoint& from) {
  return {std::int64_t{to[0]} - from[0], std::int64_t{to[1]} - from[1], std::int64_t{to[2]} - from[2]};
}

std::int64_t dot(const LatticeVector& a, const LatticeVector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

LatticeVector cross(const LatticeVector& a, const LatticeVector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

bool near_inside(const LatticePoint& p, const LatticePoint& a, const LatticePoint& b) {
  const LatticeVector ab = difference(b, a);
  const LatticeVector ap = difference(p, a);
  const std::int64_t length2 = dot(ab, ab);
  const std::int64_t along = dot(ab, ap);
  if (along <= 0 || along >= length2) return false;
  // |ab x ap| <= |ab| / 2 < 2^30: a component beyond that decides, and the squares of the rest fit 64 bits.
  std::uint64_t sum = 0;
  for (const std::int64_t c : cross(ab, ap)) {
    const std::int64_t size = std::abs(c);
    if (size >= std::int64_t{1} << 30) return false;
    sum += static_cast<std::uint64_t>(size * size);
  }
  return 4 * sum <= static_cast<std::uint64_t>(length2);
}

double distance_to_line(const LatticePoint& p, const LatticePoint& a, const LatticePoint& b) {
  const LatticeVector ab = difference(b, a);
  double sum = 0;
  for (const std::int64_t c : cross(ab, difference(p, a))) sum += static_cast<double>(c) * static_cast<double>(c);
  return std::sqrt(sum / static_cast<double>(std::max<std::int64_t>(dot(ab, ab), 1)));
}

}  // namespace zc
