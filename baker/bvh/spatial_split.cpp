// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/bvh/spatial_split.h"

#include <algorithm>
#include <array>

namespace zc {
namespace {

constexpr std::uint32_t kBins = 16;

using Point = std::array<std::uint16_t, 3>;

// Adds where the edge intersects the plane, if it has ends on both sides of it.
void add_crossing(PackedBox& box, const Point& a, const Point& b, std::size_t axis, std::uint32_t plane) {
  const Point& from = a[axis] < b[axis] ? a : b;
  const Point& to = a[axis] < b[axis] ? b : a;
  if (from[axis] >= plane || to[axis] <= plane) return;
  const std::int64_t length = to[axis] - from[axis];
  const std::int64_t part = static_cast<std::int64_t>(plane) - from[axis];
  BvhBox crossing;
  crossing.min[axis] = crossing.max[axis] = static_cast<std::uint16_t>(plane);
  for (const std::size_t other : {(axis + 1) % 3, (axis + 2) % 3}) {
    const std::int64_t scaled = from[other] * length + (std::int64_t{to[other]} - from[other]) * part;  // >= 0
    const auto low = static_cast<std::int64_t>(static_cast<double>(scaled) / static_cast<double>(length));
    crossing.min[other] = static_cast<std::uint16_t>(low);
    crossing.max[other] = static_cast<std::uint16_t>(low + (low * length < scaled ? 1 : 0));
  }
  box.add(PackedBox(crossing));
}

PackedBox plane_box(const BvhTriangle& t, std::size_t axis, std::uint32_t plane) {
  PackedBox box;
  add_crossing(box, t[0], t[1], axis, plane);
  add_crossing(box, t[1], t[2], axis, plane);
  add_crossing(box, t[2], t[0], axis, plane);
  return box;
}

void add_corners(PackedBox& box, const BvhTriangle& t, std::size_t axis, std::uint32_t low, std::uint32_t high) {
  for (const Point& corner : t)
    if (corner[axis] >= low && corner[axis] <= high) box.add(PackedBox::around(corner));
}

// Equal slabs of whole lattice units over the extent of a node.
struct Slabs {
  std::uint32_t low;
  std::uint32_t width;
  std::uint64_t reciprocal;  // (x * reciprocal) >> 32 is x / width for x below 2^16
  std::uint32_t count;

  Slabs(std::uint32_t from, std::uint32_t extent)
      : low(from),
        width(std::max(1U, (extent + kBins - 1) / kBins)),
        reciprocal(((std::uint64_t{1} << 32U) + width - 1) / width),
        count((extent + width - 1) / width) {}
  [[nodiscard]] std::uint32_t index(std::uint32_t x) const {
    return static_cast<std::uint32_t>((x - low) * reciprocal >> 32U);
  }
  [[nodiscard]] std::uint32_t first(std::uint32_t min) const { return std::min(index(min), count - 1); }
  // A flat reference on a plane belongs to the slab behind it, as side_of has it.
  [[nodiscard]] std::uint32_t last(std::uint32_t min, std::uint32_t max) const {
    return max > min ? index(max - 1) : first(min);
  }
  [[nodiscard]] std::uint32_t plane(std::uint32_t slab) const { return low + slab * width; }
};

struct SlabBins {
  std::array<PackedBox, kBins> boxes;
  std::array<std::uint32_t, kBins> entries{};
  std::array<std::uint32_t, kBins> exits{};
};

// Where a triangle's edges pass planes across an axis, to the nearest unit: enough to compare costs by, and without a
// division a plane.
class Crossings {
 public:
  Crossings(const BvhTriangle& t, std::size_t axis) {
    const Point* low = &t[0];
    const Point* middle = &t[1];
    const Point* high = &t[2];
    if ((*middle)[axis] < (*low)[axis]) std::swap(low, middle);
    if ((*high)[axis] < (*middle)[axis]) std::swap(middle, high);
    if ((*middle)[axis] < (*low)[axis]) std::swap(low, middle);
    at_ = {(*low)[axis], (*middle)[axis], (*high)[axis]};
    corners_ = {PackedBox::around(*low), PackedBox::around(*middle), PackedBox::around(*high)};
    long_ = Edge(*low, *high, axis);
    lower_ = Edge(*low, *middle, axis);
    upper_ = Edge(*middle, *high, axis);
  }

  // Adds the corners between two planes.
  void add_corners(PackedBox& box, std::uint32_t low, std::uint32_t high) const {
    for (std::size_t i = 0; i < 3; ++i)
      if (at_[i] >= low && at_[i] <= high) box.add(corners_[i]);
  }
  // Bounds on the plane; empty outside of the triangle.
  [[nodiscard]] PackedBox at_plane(std::uint32_t plane) const {
    if (plane < at_[0] || plane > at_[2]) return {};
    PackedBox box = long_.at(plane);
    box.add((plane < at_[1] ? lower_ : upper_).at(plane));
    return box;
  }

 private:
  struct Edge {
    Float4 base = {};
    Float4 slope = {};
    std::uint32_t start = 0;
    Edge() = default;
    Edge(const Point& from, const Point& to, std::size_t axis) : start(from[axis]) {
      const auto corner = [](const Point& p) {
        return Float4{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2]), 0};
      };
      base = corner(from) + 0.5F;
      const float scale = to[axis] > from[axis] ? 1.0F / static_cast<float>(to[axis] - from[axis]) : 0;
      slope = (corner(to) - corner(from)) * scale;
    }
    [[nodiscard]] PackedBox at(std::uint32_t plane) const {
      const auto point = to_ints(base + slope * static_cast<float>(plane - start));
      const auto halves = std::bit_cast<std::array<std::uint64_t, 2>>(point);
      return PackedBox::around((halves[0] & 0xFFFFU) | (halves[0] >> 16U & 0xFFFF0000U) | halves[1] << 32U);
    }
  };

  std::array<std::uint32_t, 3> at_{};  // of the corners along the axis, ascending
  std::array<PackedBox, 3> corners_;
  Edge long_, lower_, upper_;
};

// Adds a reference's pieces to the slabs that it passes through.
void add_pieces(SlabBins& bins, const Slabs& slabs, std::size_t axis, std::uint32_t first, std::uint32_t last,
                const PackedBox& reference, const BvhTriangle& triangle) {
  const Crossings crossings(triangle, axis);
  std::uint32_t low = reference.min(axis);
  PackedBox before = crossings.at_plane(low);
  for (std::uint32_t slab = first; slab <= last; ++slab) {
    const std::uint32_t high = slab == last ? reference.max(axis) : slabs.plane(slab + 1);
    const PackedBox behind = crossings.at_plane(high);
    PackedBox piece = before;
    piece.add(behind);
    crossings.add_corners(piece, low, high);
    piece.clip(reference);
    if (!piece.empty()) bins.boxes[slab].add(piece);
    before = behind;
    low = high;
  }
}

}  // namespace

PackedBox slab_box(const BvhTriangle& triangle, std::size_t axis, std::uint32_t low, std::uint32_t high) {
  PackedBox box = plane_box(triangle, axis, low);
  box.add(plane_box(triangle, axis, high));
  add_corners(box, triangle, axis, low, high);
  return box;
}

SpatialSplit find_spatial_split(std::span<const PackedBox> references, const PackedBox& box,
                                std::span<const BvhTriangle> triangles) {
  SpatialSplit best;
  std::size_t axis = 0;
  for (std::size_t other = 1; other < 3; ++other)
    if (box.extent(other) > box.extent(axis)) axis = other;
  const auto extent = static_cast<std::uint32_t>(box.extent(axis));
  if (extent < 2) return best;
  const Slabs slabs(box.min(axis), extent);
  SlabBins bins;
  for (const PackedBox& r : references) {
    const std::uint32_t first = slabs.first(r.min(axis));
    const std::uint32_t last = slabs.last(r.min(axis), r.max(axis));
    ++bins.entries[first];
    ++bins.exits[last];
    if (first == last) {
      bins.boxes[first].add(r);
    } else {
      add_pieces(bins, slabs, axis, first, last, r, triangles[r.triangle()]);
    }
  }
  std::array<std::int64_t, kBins> right_cost{};
  std::array<PackedBox, kBins> right_box;
  std::array<std::uint32_t, kBins> right_count{};
  PackedBox side;
  std::uint32_t count = 0;
  for (std::uint32_t b = slabs.count - 1; b > 0; --b) {
    side.add(bins.boxes[b]);
    count += bins.exits[b];
    right_box[b] = side;
    right_count[b] = count;
    right_cost[b] = side.area() * count;
  }
  side = {};
  count = 0;
  for (std::uint32_t b = 1; b < slabs.count; ++b) {
    side.add(bins.boxes[b - 1]);
    count += bins.entries[b - 1];
    if (count == 0 || right_count[b] == 0) continue;
    const std::int64_t cost = side.area() * count + right_cost[b];
    if (cost < best.cost) best = {cost, count, right_count[b], side, right_box[b], axis, slabs.plane(b)};
  }
  return best;
}

}  // namespace zc
