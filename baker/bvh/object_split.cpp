// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/bvh/object_split.h"

#include <algorithm>
#include <array>

#include "base/check.h"

namespace zc {
namespace {

constexpr std::uint32_t kBinsLimit = 64;

// The more references, the more of what a plane misplaces pays for.
std::uint32_t bins_for(std::size_t references) { return references >= 512 ? kBinsLimit : references >= 128 ? 32 : 16; }

// Of the centres, doubled; the last lane means nothing.
struct CenterRange {
  Float4 low;
  Float4 high;

  explicit CenterRange(std::span<const PackedBox> references) : low(references[0].centers()), high(low) {
    for (const PackedBox& r : references) {
      const Float4 c = r.centers();
      low = c < low ? c : low;
      high = c > high ? c : high;
    }
  }
  [[nodiscard]] float extent(std::size_t axis) const { return high[axis] - low[axis]; }
  [[nodiscard]] std::size_t widest() const {
    std::size_t best = 0;
    for (std::size_t axis = 1; axis < 3; ++axis)
      if (extent(axis) > extent(best)) best = axis;
    return best;
  }
};

// Order along an axis: by centre (17 bits), then by triangle (24 bits), then by place.
using Keys = std::array<std::uint64_t, kSweepLimit>;

void sort_keys(std::span<const PackedBox> references, std::size_t axis, Keys& keys) {
  for (std::size_t i = 0; i < references.size(); ++i) {
    const std::uint64_t key = std::uint64_t{references[i].center(axis)} << 40U |
                              std::uint64_t{references[i].triangle() & 0xFFFFFFU} << 8U | i;
    std::size_t at = i;
    for (; at > 0 && keys[at - 1] > key; --at) keys[at] = keys[at - 1];
    keys[at] = key;
  }
}

ObjectSplit sweep(std::span<const PackedBox> references) {
  if (references.size() == 2) {  // all divisions cost alike
    ObjectSplit split;
    split.left = 1;
    split.left_box = references[0];
    split.right_box = references[1];
    split.cost = split.left_box.half_area() + split.right_box.half_area();
    split.kind = ObjectSplit::Kind::kOrdered;
    split.order[1] = 1;
    return split;
  }
  std::array<Keys, 3> by_axis;
  std::array<std::int64_t, kSweepLimit> right;
  ObjectSplit best;
  best.kind = ObjectSplit::Kind::kOrdered;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Keys& keys = by_axis[axis];
    sort_keys(references, axis, keys);
    PackedBox box;
    for (std::size_t i = references.size() - 1; i > 0; --i) {
      box.add(references[keys[i] & 0xFFU]);
      right[i] = box.half_area() * static_cast<std::int64_t>(references.size() - i);
    }
    box = {};
    for (std::size_t left = 1; left < references.size(); ++left) {
      box.add(references[keys[left - 1] & 0xFFU]);
      const std::int64_t cost = box.half_area() * static_cast<std::int64_t>(left) + right[left];
      if (cost < best.cost) {
        best.cost = cost;
        best.axis = axis;
        best.left = left;
        best.left_box = box;
      }
    }
  }
  for (std::size_t i = 0; i < references.size(); ++i) {
    best.order[i] = static_cast<std::uint8_t>(by_axis[best.axis][i] & 0xFFU);
    if (i >= best.left) best.right_box.add(references[best.order[i]]);
  }
  return best;
}

struct Bins {
  std::array<PackedBox, kBinsLimit> boxes;
  std::array<std::uint32_t, kBinsLimit> counts{};
};

ObjectSplit bin(std::span<const PackedBox> references, const CenterRange& centers) {
  const std::uint32_t count_of_bins = bins_for(references.size());
  std::array<Bins, 3> bins;
  // The greatest centre stays below the last bin's end: extents are below 2^18, where one part more is many roundings.
  const Float4 scale = static_cast<float>(count_of_bins) / (centers.high - centers.low + 1.0F);
  for (const PackedBox& r : references) {
    const Int4 b = to_ints((r.centers() - centers.low) * scale);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto at = static_cast<std::uint32_t>(b[axis]);
      bins[axis].boxes[at].add(r);
      ++bins[axis].counts[at];
    }
  }
  ObjectSplit best;
  best.kind = ObjectSplit::Kind::kBinned;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (centers.extent(axis) == 0) continue;
    std::array<std::int64_t, kBinsLimit> right{};
    std::array<PackedBox, kBinsLimit> right_box;
    PackedBox box;
    std::uint32_t count = 0;
    for (std::uint32_t b = count_of_bins - 1; b > 0; --b) {
      box.add(bins[axis].boxes[b]);
      count += bins[axis].counts[b];
      right_box[b] = box;
      right[b] = count > 0 ? box.half_area() * count : 0;
    }
    box = {};
    count = 0;
    for (std::uint32_t b = 0; b + 1 < count_of_bins; ++b) {
      if (bins[axis].counts[b] == 0) continue;  // the same division as before
      box.add(bins[axis].boxes[b]);
      count += bins[axis].counts[b];
      if (count == references.size()) break;
      const std::int64_t cost = box.half_area() * count + right[b + 1];
      if (cost < best.cost) {
        best.cost = cost;
        best.axis = axis;
        best.left = count;
        best.left_box = box;
        best.right_box = right_box[b + 1];
        best.last_bin = static_cast<std::int32_t>(b);
      }
    }
  }
  ZC_CHECK(best.left > 0);
  best.low = centers.low[best.axis];
  best.scale = scale[best.axis];
  return best;
}

}  // namespace

ObjectSplit halve(std::span<const PackedBox> references) {
  ObjectSplit split;
  split.axis = CenterRange(references).widest();
  split.left = references.size() / 2;
  return split;
}

ObjectSplit find_object_split(std::span<const PackedBox> references) {
  if (references.size() <= kSweepLimit) return sweep(references);
  const CenterRange centers(references);
  if (centers.extent(centers.widest()) > 0) return bin(references, centers);
  ObjectSplit split = halve(references);
  for (const PackedBox& r : references) split.left_box.add(r);
  split.right_box = split.left_box;
  split.cost = split.left_box.half_area() * static_cast<std::int64_t>(references.size());
  return split;
}

void apply(const ObjectSplit& split, std::span<PackedBox> references) {
  if (split.kind == ObjectSplit::Kind::kBinned) {
    std::partition(references.begin(), references.end(), [&](const PackedBox& r) {
      return static_cast<std::int32_t>((static_cast<float>(r.center(split.axis)) - split.low) * split.scale) <=
             split.last_bin;
    });
  } else if (split.kind == ObjectSplit::Kind::kOrdered) {
    std::array<PackedBox, kSweepLimit> from;
    std::ranges::copy(references, from.begin());
    for (std::size_t i = 0; i < references.size(); ++i) references[i] = from[split.order[i]];
  } else {
    std::ranges::nth_element(references, references.begin() + static_cast<std::ptrdiff_t>(split.left), {},
                             [&](const PackedBox& r) { return std::pair(r.center(split.axis), r.triangle()); });
  }
}

}  // namespace zc
