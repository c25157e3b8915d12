// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/bvh/object_split.h"

#include <algorithm>
#include <array>

#include "base/check.h"

namespace zc {
namespace {

constexpr std::uint32_t kBins = 16;
constexpr std::uint32_t kFraction = 28;

struct CenterRange {
  std::array<std::uint32_t, 3> low = {UINT32_MAX, UINT32_MAX, UINT32_MAX};
  std::array<std::uint32_t, 3> high = {};

  explicit CenterRange(std::span<const PackedBox> references) {
    for (const PackedBox& r : references) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], r.center(axis));
        high[axis] = std::max(high[axis], r.center(axis));
      }
    }
  }
  [[nodiscard]] std::uint32_t extent(std::size_t axis) const { return high[axis] - low[axis]; }
  [[nodiscard]] std::size_t widest() const {
    std::size_t best = 0;
    for (std::size_t axis = 1; axis < 3; ++axis)
      if (extent(axis) > extent(best)) best = axis;
    return best;
  }
};

// Order along an axis: by centre (17 bits), then by triangle (24 bits), then by place.
using Keys = std::array<std::uint64_t, kSweepMost>;

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
  Keys keys{};
  std::array<std::int64_t, kSweepMost> right{};
  ObjectSplit best;
  for (std::size_t axis = 0; axis < 3; ++axis) {
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
  sort_keys(references, best.axis, keys);
  for (std::size_t i = best.left; i < references.size(); ++i) best.right_box.add(references[keys[i] & 0xFFU]);
  return best;
}

struct Bins {
  std::array<PackedBox, kBins> boxes;
  std::array<std::uint32_t, kBins> counts{};
};

ObjectSplit bin(std::span<const PackedBox> references, const CenterRange& centers) {
  std::array<Bins, 3> bins;
  std::array<std::uint32_t, 3> scale{};  // bins per unit, 28 fractional bits: a product stays below 2^32
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (centers.extent(axis) > 0)
      scale[axis] = static_cast<std::uint32_t>((std::uint64_t{kBins} << kFraction) / (centers.extent(axis) + 1));
  for (const PackedBox& r : references) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::uint32_t b = (r.center(axis) - centers.low[axis]) * scale[axis] >> kFraction;
      bins[axis].boxes[b].add(r);
      ++bins[axis].counts[b];
    }
  }
  ObjectSplit best;
  best.binned = true;
  std::uint32_t best_bin = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (scale[axis] == 0) continue;  // all centres agree
    std::array<std::int64_t, kBins> right{};
    std::array<PackedBox, kBins> right_box;
    PackedBox box;
    std::uint32_t count = 0;
    for (std::uint32_t b = kBins - 1; b > 0; --b) {
      box.add(bins[axis].boxes[b]);
      count += bins[axis].counts[b];
      right_box[b] = box;
      right[b] = count > 0 ? box.half_area() * count : 0;
    }
    box = {};
    count = 0;
    for (std::uint32_t b = 0; b + 1 < kBins; ++b) {
      box.add(bins[axis].boxes[b]);
      count += bins[axis].counts[b];
      if (count == 0 || count == references.size()) continue;
      const std::int64_t cost = box.half_area() * count + right[b + 1];
      if (cost < best.cost) {
        best.cost = cost;
        best.axis = axis;
        best.left = count;
        best.left_box = box;
        best.right_box = right_box[b + 1];
        best_bin = b;
      }
    }
  }
  ZC_CHECK(best.left > 0);
  // The last unit of the bin: (unit * scale) >> kFraction is at most best_bin.
  best.last_center = centers.low[best.axis] + (((best_bin + 1) << kFraction) - 1) / scale[best.axis];
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
  if (references.size() <= kSweepMost) return sweep(references);
  const CenterRange centers(references);
  if (centers.extent(centers.widest()) > 0) return bin(references, centers);
  ObjectSplit split = halve(references);
  for (const PackedBox& r : references) split.left_box.add(r);
  split.right_box = split.left_box;
  split.cost = split.left_box.half_area() * static_cast<std::int64_t>(references.size());
  return split;
}

void apply(const ObjectSplit& split, std::span<PackedBox> references) {
  if (split.binned) {
    std::ranges::partition(references, [&](const PackedBox& r) { return r.center(split.axis) <= split.last_center; });
  } else if (references.size() <= kSweepMost) {
    Keys keys{};
    std::array<PackedBox, kSweepMost> from;
    std::ranges::copy(references, from.begin());
    sort_keys(references, split.axis, keys);
    for (std::size_t i = 0; i < references.size(); ++i) references[i] = from[keys[i] & 0xFFU];
  } else {
    std::ranges::nth_element(references, references.begin() + static_cast<std::ptrdiff_t>(split.left), {},
                             [&](const PackedBox& r) { return std::pair(r.center(split.axis), r.triangle()); });
  }
}

}  // namespace zc
