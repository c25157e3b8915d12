// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/clip.h"

#include <algorithm>

namespace zc {
namespace {

// GCC's 128-bit integers are an extension; products of two extents and a rounding step need 92 bits.
__extension__ typedef __int128 Wide;

std::uint32_t point_shift(const LatticePoint& p, const CellGrid& grid) {
  return std::max(grid.border_shift(p[0]), grid.border_shift(p[1]));
}

// a + (b - a) * num / den, rounded to a multiple of 2^shift, halves upwards; den > 0.
std::int32_t interpolate(std::int32_t a, std::int32_t b, std::int64_t num, std::int64_t den, std::uint32_t shift) {
  const Wide unit = Wide{den} << shift;
  const Wide twice = 2 * (Wide{a} * den + (Wide{b} - a) * num) + unit;
  Wide quotient = twice / (2 * unit);
  if (twice % (2 * unit) < 0) --quotient;
  return static_cast<std::int32_t>(quotient << shift);
}

class Clipper {
 public:
  Clipper(std::size_t axis, std::int32_t plane, const CellGrid& grid, std::vector<EdgeSplit>& splits)
      : axis_(axis), plane_(plane), grid_(grid), splits_(splits) {}

  // A vertex in the plane becomes a border vertex.
  [[nodiscard]] LatticePoint settle(LatticePoint p) const {
    if (p[axis_] != plane_) return p;
    const std::uint32_t shift = point_shift(p, grid_);
    p[1 - axis_] = round_to_step(p[1 - axis_], shift);
    p[2] = round_to_step(p[2], shift);
    return p;
  }

  LatticePoint intersect(LatticePoint a, LatticePoint b) {
    if (b < a) std::swap(a, b);
    std::int64_t den = std::int64_t{b[axis_]} - a[axis_];
    std::int64_t num = std::int64_t{plane_} - a[axis_];
    if (den < 0) {
      den = -den;
      num = -num;
    }
    // An edge along another border may be met by that border's nodes: the coarser of the two steps counts.
    std::uint32_t shift = grid_.border_shift(plane_);
    const std::size_t other = 1 - axis_;
    const bool along_border = a[other] == b[other] && grid_.may_be_border(a[other]);
    if (along_border) shift = std::max(shift, grid_.border_shift(a[other]));
    LatticePoint p;
    p[axis_] = plane_;
    p[other] = along_border ? a[other] : interpolate(a[other], b[other], num, den, shift);
    p[2] = interpolate(a[2], b[2], num, den, shift);
    if (along_border && p != a && p != b) splits_.push_back({a, b, p});
    return p;
  }

  // The part of the face on one side (sign -1: low, +1: high), as a fan.
  void keep_side(const LooseFace& face, int sign, std::vector<LooseFace>& out) {
    std::array<LatticePoint, 4> corners;
    std::size_t count = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const LatticePoint& a = face.p[i];
      const LatticePoint& b = face.p[(i + 1) % 3];
      const std::int64_t da = sign * (std::int64_t{a[axis_]} - plane_);
      const std::int64_t db = sign * (std::int64_t{b[axis_]} - plane_);
      if (da >= 0) corners[count++] = a;
      if ((da > 0 && db < 0) || (da < 0 && db > 0)) corners[count++] = intersect(a, b);
    }
    for (std::size_t i = 2; i < count; ++i) {
      if (is_degenerate(corners[0], corners[i - 1], corners[i])) continue;
      out.push_back({{corners[0], corners[i - 1], corners[i]}, face.material, face.ground});
    }
  }

 private:
  std::size_t axis_;
  std::int32_t plane_;
  const CellGrid& grid_;
  std::vector<EdgeSplit>& splits_;
};

}  // namespace

ClipResult clip_faces(const std::vector<LooseFace>& faces, std::size_t axis, std::int32_t plane, const CellGrid& grid,
                      std::vector<EdgeSplit>& splits) {
  ClipResult out;
  Clipper clipper(axis, plane, grid, splits);
  for (LooseFace face : faces) {
    for (LatticePoint& p : face.p) p = clipper.settle(p);
    if (is_degenerate(face.p[0], face.p[1], face.p[2])) continue;
    const auto [low, high] = std::minmax({face.p[0][axis], face.p[1][axis], face.p[2][axis]});
    if (high <= plane) {
      out.low.push_back(face);
    } else if (low >= plane) {
      out.high.push_back(face);
    } else {
      clipper.keep_side(face, -1, out.low);
      clipper.keep_side(face, +1, out.high);
    }
  }
  return out;
}

void apply_splits(std::vector<LooseFace>& faces, const std::vector<EdgeSplit>& splits) {
  if (splits.empty()) return;
  const auto find = [&](LatticePoint a, LatticePoint b) -> const EdgeSplit* {
    if (b < a) std::swap(a, b);
    const auto at =
        std::lower_bound(splits.begin(), splits.end(), std::pair{a, b}, [](const EdgeSplit& s, const auto& k) {
          return std::pair{s.a, s.b} < k;
        });
    return at != splits.end() && at->a == a && at->b == b ? &*at : nullptr;
  };
  // Faces grow at the end while they are halved: each half is looked at again.
  for (std::size_t i = 0; i < faces.size(); ++i) {
    for (std::size_t edge = 0; edge < 3;) {
      LooseFace& face = faces[i];
      const EdgeSplit* split = find(face.p[edge], face.p[(edge + 1) % 3]);
      if (split == nullptr) {
        ++edge;
        continue;
      }
      LooseFace half = face;
      half.p[edge] = split->point;
      face.p[(edge + 1) % 3] = split->point;
      faces.push_back(half);
      edge = 0;
    }
  }
  std::erase_if(faces, [](const LooseFace& f) { return is_degenerate(f.p[0], f.p[1], f.p[2]); });
}

}  // namespace zc
