// SPDX-License-Identifier: Apache-2.0
#include "streamer/draco/mesh.h"

#include <algorithm>
#include <cstddef>

#include "streamer/draco/connectivity.h"

namespace zc {
namespace {

using Value = std::array<std::int32_t, 3>;

// Whole numbers as symbols: 0, -1, 1, -2...
std::int32_t signed_of(std::uint32_t symbol) {
  const auto half = static_cast<std::int32_t>(symbol >> 1U);
  return (symbol & 1U) == 0 ? half : -half - 1;
}

class Positions {
 public:
  // The last two are empty where predictions need no neighbours.
  Positions(const DracoLayout& layout, std::span<std::array<std::uint16_t, 3>> values, ConstVertexOfCorner corners,
            WordOfCorner opposites)
      : layout_(layout),
        values_(values),
        corners_(corners),
        opposites_(opposites),
        steps_left_(6 * std::uint64_t{corners.triangle_count()} + 2 * values.size()) {}

  bool decode(std::span<const std::uint32_t> corner_of_value, std::span<std::uint32_t> table) {
    using Prediction = DracoLayout::Prediction;
    DracoSymbols corrections;
    if (!corrections.start(layout_.corrections, table)) return false;
    if (layout_.prediction == Prediction::kParallelograms)
      for (std::size_t i = 0; i < creases_.size(); ++i) {
        creases_left_[i] = layout_.creases[i].count;
        if (creases_left_[i] > 0 && !creases_[i].start(layout_.creases[i].bits)) return false;
      }
    for (std::uint32_t p = 0; p < values_.size(); ++p) {
      Value predicted{};
      bool known = false;
      if (p > 0) {
        if (layout_.prediction == Prediction::kParallelogram)
          known = parallelogram(p, corner_of_value[p], predicted);
        else if (layout_.prediction == Prediction::kParallelograms &&
                 !parallelograms(p, corner_of_value[p], known, predicted))
          return false;
        if (!known) predicted = value(p - 1);
      }
      if (!put(p, predicted, corrections.read<3>())) return false;
    }
    return true;
  }

 private:
  [[nodiscard]] Value value(std::uint32_t p) const { return {values_[p][0], values_[p][1], values_[p][2]}; }

  bool put(std::uint32_t p, const Value& predicted, const std::array<std::uint32_t, 3>& symbols) {
    const bool wraps = layout_.prediction != DracoLayout::Prediction::kNone;
    const std::int64_t low = wraps ? layout_.min : 0;
    const std::int64_t high = wraps ? layout_.max : UINT16_MAX;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::int64_t v = signed_of(symbols[axis]);
      if (wraps) {
        v += std::clamp<std::int64_t>(predicted[axis], low, high);
        if (v > high)
          v -= high - low + 1;
        else if (v < low)
          v += high - low + 1;
      }
      if (v < low || v > high) return false;
      values_[p][axis] = static_cast<std::uint16_t>(v);
    }
    return true;
  }

  // From the triangle across from a corner, if all its values are there.
  bool parallelogram(std::uint32_t p, std::uint32_t corner, Value& out) const {
    const std::uint32_t across = opposites_[corner];
    if (across == kNoCorner) return false;
    const std::uint32_t far = corners_[across];
    const std::uint32_t next = corners_[next_corner(across)];
    const std::uint32_t previous = corners_[previous_corner(across)];
    if (far >= p || next >= p || previous >= p) return false;
    for (std::size_t axis = 0; axis < 3; ++axis)
      out[axis] = values_[next][axis] + values_[previous][axis] - values_[far][axis];
    return true;
  }

  // The mean of those around the value's vertex that do not cross a crease, first to the left, then to the right.
  bool parallelograms(std::uint32_t p, std::uint32_t start, bool& known, Value& out) {
    std::array<Value, DracoLayout::kParallelogramsMost> found{};
    std::size_t count = 0;
    bool left = true;
    for (std::uint32_t corner = start; corner != kNoCorner && count < found.size();) {
      if (steps_left_-- == 0) return false;
      count += parallelogram(p, corner, found[count]) ? 1 : 0;
      corner = left ? swing_left(corner) : swing_right(corner);
      if (corner == start) break;
      if (corner == kNoCorner && left) {
        left = false;
        corner = swing_right(start);
      }
    }
    if (count == 0) return true;
    if (creases_left_[count - 1] < count) return false;
    creases_left_[count - 1] -= static_cast<std::uint32_t>(count);
    std::int32_t used = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (creases_[count - 1].read()) continue;
      ++used;
      for (std::size_t axis = 0; axis < 3; ++axis) out[axis] += found[i][axis];
    }
    known = used > 0;
    if (used > 1)
      for (std::int32_t& v : out) v /= used;
    return true;
  }

  [[nodiscard]] std::uint32_t swing_left(std::uint32_t corner) const {
    const std::uint32_t across = opposites_[next_corner(corner)];
    return across == kNoCorner ? kNoCorner : next_corner(across);
  }
  [[nodiscard]] std::uint32_t swing_right(std::uint32_t corner) const {
    const std::uint32_t across = opposites_[previous_corner(corner)];
    return across == kNoCorner ? kNoCorner : previous_corner(across);
  }

  const DracoLayout& layout_;
  std::span<std::array<std::uint16_t, 3>> values_;
  ConstVertexOfCorner corners_;
  WordOfCorner opposites_;
  std::array<RansBits, DracoLayout::kParallelogramsMost> creases_;
  std::array<std::uint32_t, DracoLayout::kParallelogramsMost> creases_left_{};
  std::uint64_t steps_left_;  // around vertices: each corner belongs to one
};

using Triangles = std::span<std::array<std::uint32_t, 3>>;

bool decode_edgebreaker(const DracoLayout& layout, std::span<std::array<std::uint16_t, 3>> vertices,
                        Triangles triangles, std::span<std::uint32_t> words) {
  const std::span<std::uint32_t> first = words.first(3 * triangles.size());
  const std::size_t last = std::max<std::uint64_t>(layout.vertices, layout.corrections.table_words());
  const std::span<std::uint32_t> middle = words.subspan(first.size(), words.size() - first.size() - last);
  const std::span<std::uint32_t> behind = words.last(last);
  const WordOfCorner opposites(first);
  DracoConnectivity::Memory memory{VertexOfCorner(triangles), opposites, behind.first(layout.vertices), {}, {}};
  if (layout.by_valence) {
    memory.valences = std::as_writable_bytes(middle).first(layout.vertices);
    memory.symbols = std::as_writable_bytes(middle).subspan((layout.vertices + 3) / 4 * 4);
  }
  DracoConnectivity connectivity(layout, memory);
  const std::span<std::uint32_t> corner_of_value = middle.first(layout.values);
  if (!connectivity.glue() || !connectivity.number(corner_of_value)) return false;
  return Positions(layout, vertices, ConstVertexOfCorner(triangles), opposites).decode(corner_of_value, behind);
}

bool read_coded_indices(const DracoLayout& layout, Triangles triangles, std::span<std::uint32_t> words) {
  DracoSymbols symbols;
  if (!symbols.start(layout.index_symbols, words)) return false;
  std::int64_t last = 0;
  for (auto& triangle : triangles)
    for (std::uint32_t& vertex : triangle) {
      const std::uint32_t symbol = symbols.read<1>()[0];
      last += (symbol & 1U) != 0 ? -std::int64_t{symbol >> 1U} : std::int64_t{symbol >> 1U};
      if (last < 0 || last >= layout.values) return false;
      vertex = static_cast<std::uint32_t>(last);
    }
  return true;
}

bool read_plain_indices(const DracoLayout& layout, Triangles triangles) {
  ByteReader in(layout.plain_indices);
  for (auto& triangle : triangles)
    for (std::uint32_t& vertex : triangle) {
      if (layout.values >= 1U << 16U) {
        vertex = in.varint();
      } else {
        vertex = in.byte();
        if (layout.values >= 256) vertex |= std::uint32_t{in.byte()} << 8U;
      }
      if (vertex >= layout.values) return false;
    }
  return !in.failed();
}

}  // namespace

bool decode_draco(const DracoLayout& layout, std::span<std::array<std::uint16_t, 3>> vertices, Triangles triangles,
                  std::span<std::uint32_t> words) {
  if (layout.edgebreaker) return decode_edgebreaker(layout, vertices, triangles, words);
  const bool read =
      layout.coded_indices ? read_coded_indices(layout, triangles, words) : read_plain_indices(layout, triangles);
  return read && Positions(layout, vertices, ConstVertexOfCorner({}), WordOfCorner({})).decode({}, words);
}

}  // namespace zc
