// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/cut/clip.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <iterator>
#include <tuple>

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

// A corner of a loose face.
struct Corner {
  LatticePoint p;
  float moved = 0;

  auto operator<=>(const Corner&) const = default;
};

Corner corner_of(const LooseFace& face, std::size_t i) { return {face.p[i], face.moved[i]}; }

// From p to the edge, and from there to the edge as it was before its ends moved; at most.
float distance_to_edge(const LatticePoint& p, const Corner& a, const Corner& b) {
  const glm::dvec3 edge = to_dvec(b.p) - to_dvec(a.p);
  const glm::dvec3 to_p = to_dvec(p) - to_dvec(a.p);
  const double t = std::clamp(glm::dot(to_p, edge) / glm::dot(edge, edge), 0.0, 1.0);
  return static_cast<float>(glm::length(to_p - t * edge) + std::lerp<double, double, double>(a.moved, b.moved, t));
}

class Clipper {
 public:
  Clipper(std::size_t axis, std::int32_t plane, const CellGrid& grid, std::vector<EdgeSplit>& splits)
      : axis_(axis), plane_(plane), grid_(grid), splits_(splits) {}

  // A vertex in the plane becomes a border vertex.
  void settle(LatticePoint& p, float& moved) const {
    if (p[axis_] != plane_) return;
    const LatticePoint before = p;
    const std::uint32_t shift = point_shift(p, grid_);
    const std::size_t other = 1 - axis_;
    p[other] = round_to_step(p[other], shift);
    p[2] = round_to_step(p[2], shift);
    moved += static_cast<float>(glm::distance(to_dvec(before), to_dvec(p)));
  }

  Corner intersect(Corner from, Corner to) {
    if (to < from) std::swap(from, to);
    const LatticePoint& a = from.p;
    const LatticePoint& b = to.p;
    std::int64_t den = std::int64_t{b[axis_]} - a[axis_];
    std::int64_t num = std::int64_t{plane_} - a[axis_];
    if (den < 0) {
      den = -den;
      num = -num;
    }
    // An edge along another border may touch that border's nodes: the coarser of the two steps counts.
    std::uint32_t shift = grid_.border_shift(plane_);
    const std::size_t other = 1 - axis_;
    const bool along_border = a[other] == b[other] && grid_.may_be_border(a[other]);
    if (along_border) shift = std::max(shift, grid_.border_shift(a[other]));
    LatticePoint p;
    p[axis_] = plane_;
    p[other] = along_border ? a[other] : interpolate(a[other], b[other], num, den, shift);
    p[2] = interpolate(a[2], b[2], num, den, shift);
    const float moved = distance_to_edge(p, from, to);
    if (along_border && p != a && p != b) splits_.push_back({a, b, p, moved});
    return {p, moved};
  }

  // The part of the face on one side (sign -1: low, +1: high), as a fan.
  void keep_side(const LooseFace& face, int sign, std::vector<LooseFace>& out) {
    std::array<Corner, 4> corners;
    std::size_t count = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const Corner a = corner_of(face, i);
      const Corner b = corner_of(face, (i + 1) % 3);
      const std::int64_t da = sign * (std::int64_t{a.p[axis_]} - plane_);
      const std::int64_t db = sign * (std::int64_t{b.p[axis_]} - plane_);
      if (da >= 0) corners[count++] = a;
      if ((da > 0 && db < 0) || (da < 0 && db > 0)) corners[count++] = intersect(a, b);
    }
    const float share = face.share / 2 / static_cast<float>(count - 2);
    for (std::size_t i = 2; i < count; ++i) {
      const auto& [a, b, c] = std::tie(corners[0], corners[i - 1], corners[i]);
      if (is_degenerate(a.p, b.p, c.p)) continue;
      out.push_back({{a.p, b.p, c.p}, {a.moved, b.moved, c.moved}, share, face.material, face.ground});
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
    for (std::size_t i = 0; i < 3; ++i) clipper.settle(face.p[i], face.moved[i]);
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
    // Of several, which differ in `moved` alone, the last: the farthest.
    const auto behind =
        std::upper_bound(splits.begin(), splits.end(), std::pair{a, b}, [](const auto& k, const EdgeSplit& s) {
          return k < std::pair{s.a, s.b};
        });
    if (behind == splits.begin()) return nullptr;
    const EdgeSplit& last = *std::prev(behind);
    return last.a == a && last.b == b ? &last : nullptr;
  };
  // Faces grow at the end while they are halved: each half is tried again.
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
      half.moved[edge] = split->moved;
      face.p[(edge + 1) % 3] = split->point;
      face.moved[(edge + 1) % 3] = split->moved;
      faces.push_back(half);
      edge = 0;
    }
  }
  std::erase_if(faces, [](const LooseFace& f) { return is_degenerate(f.p[0], f.p[1], f.p[2]); });
}

}  // namespace zc
