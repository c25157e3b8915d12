// SPDX-License-Identifier: GPL-3.0-or-later
// Dividing references into two groups, each reference into one of them, by the surface area heuristic: binned (Wald
// 2007, "On fast construction of SAH-based bounding volume hierarchies") where there are many, every division where
// there are few. Costs are half areas times references. Deterministic. Thread-safe: no state.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "baker/bvh/packed_box.h"

namespace zc {

inline constexpr std::size_t kSweepLimit = 12;  // references up to which every division is tried

struct ObjectSplit {
  std::int64_t cost = std::numeric_limits<std::int64_t>::max();
  std::size_t left = 0;  // references on the left
  PackedBox left_box;
  PackedBox right_box;
  std::size_t axis = 0;
  // How the sides are told apart.
  enum class Kind : std::uint8_t {
    kMedian,   // by the order of centres along the axis
    kBinned,   // by the bin of the centre along the axis
    kOrdered,  // by the places in `order`; of at most kSweepLimit references
  };
  Kind kind = Kind::kMedian;
  std::int32_t last_bin = 0;  // on the left
  float low = 0;              // centre, doubled, from which bins are counted
  float scale = 0;            // bins per unit
  std::array<std::uint8_t, kSweepLimit> order = {};
};

// Finds the best division of at least two references. All of equal centres are halved.
ObjectSplit find_object_split(std::span<const PackedBox> references);

// Reorders the references: the split's left ones come first.
void apply(const ObjectSplit& split, std::span<PackedBox> references);

// Halves the references along the axis on which their centres differ most.
ObjectSplit halve(std::span<const PackedBox> references);

}  // namespace zc
