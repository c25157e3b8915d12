// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/bvh/binned_sah.h"

#include <bit>
#include <limits>
#include <span>

#include "base/check.h"

namespace zc {
namespace {

constexpr std::uint32_t kBins = 16;
constexpr std::size_t kSweepMost = 12;  // references up to which every division is tried

// Twice the centre of the box.
std::uint32_t center(const BvhReference& r, std::size_t axis) { return std::uint32_t{r.box.min[axis]} + r.box.max[axis]; }

struct Split {
  std::size_t axis = 0;
  std::size_t left = 0;  // references on the left; 0: none found
};

class Builder {
 public:
  explicit Builder(std::vector<BvhReference> references) {
    tree_.references = std::move(references);
    tree_.nodes.reserve(2 * tree_.references.size());
  }

  BinaryTree run() {
    tree_.nodes.emplace_back();
    divide(0, 0, tree_.references.size(), 1);
    return std::move(tree_);
  }

 private:
  using Range = std::span<BvhReference>;

  void sort(Range range, std::size_t axis) const {
    std::ranges::sort(range, [axis](const BvhReference& a, const BvhReference& b) {
      const std::uint32_t ca = center(a, axis);
      const std::uint32_t cb = center(b, axis);
      return ca != cb ? ca < cb : a.triangle < b.triangle;
    });
  }

  static std::size_t split_at_median(Range range, std::size_t axis) {
    const std::size_t middle = range.size() / 2;
    std::ranges::nth_element(range, range.begin() + static_cast<std::ptrdiff_t>(middle),
                             [axis](const BvhReference& a, const BvhReference& b) {
                               const std::uint32_t ca = center(a, axis);
                               const std::uint32_t cb = center(b, axis);
                               return ca != cb ? ca < cb : a.triangle < b.triangle;
                             });
    return middle;
  }

  std::size_t sweep(Range range) const {
    std::array<std::int64_t, kSweepMost> right{};
    std::int64_t best_cost = std::numeric_limits<std::int64_t>::max();
    Split best;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      sort(range, axis);
      BvhBox box;
      for (std::size_t i = range.size() - 1; i > 0; --i) {
        box.add(range[i].box);
        right[i] = box.half_area() * static_cast<std::int64_t>(range.size() - i);
      }
      box = {};
      for (std::size_t left = 1; left < range.size(); ++left) {
        box.add(range[left - 1].box);
        const std::int64_t cost = box.half_area() * static_cast<std::int64_t>(left) + right[left];
        if (cost < best_cost) {
          best_cost = cost;
          best = {axis, left};
        }
      }
    }
    if (best.axis != 2) sort(range, best.axis);
    return best.left;
  }

  // Arranges the references and returns how many go left; at least two are there.
  std::size_t split(Range range, std::uint32_t depth) const {
    std::array<std::uint32_t, 3> low;
    std::array<std::uint32_t, 3> high;
    low.fill(std::numeric_limits<std::uint32_t>::max());
    high.fill(0);
    for (const BvhReference& r : range) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], center(r, axis));
        high[axis] = std::max(high[axis], center(r, axis));
      }
    }
    std::size_t widest = 0;
    for (std::size_t axis = 1; axis < 3; ++axis)
      if (high[axis] - low[axis] > high[widest] - low[widest]) widest = axis;
    // Halving from here on must end within the depth.
    const auto halvings = static_cast<std::uint32_t>(std::bit_width(range.size()));
    if (high[widest] == low[widest] || depth + halvings >= kBinaryDepthMax) return split_at_median(range, widest);
    if (range.size() <= kSweepMost) return sweep(range);

    struct Bin {
      BvhBox box;
      std::uint32_t count = 0;
    };
    std::array<std::array<Bin, kBins>, 3> bins;
    std::array<std::uint32_t, 3> scale;  // bins per unit, 16 fractional bits: (2^18 wide) * scale stays below 2^32
    for (std::size_t axis = 0; axis < 3; ++axis) scale[axis] = (kBins << 16U) / (high[axis] - low[axis] + 1);
    const auto bin_of = [&](const BvhReference& r, std::size_t axis) {
      return static_cast<std::uint32_t>(std::uint64_t{center(r, axis) - low[axis]} * scale[axis] >> 16U);
    };
    for (const BvhReference& r : range) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        Bin& bin = bins[axis][bin_of(r, axis)];
        bin.box.add(r.box);
        ++bin.count;
      }
    }
    std::int64_t best_cost = std::numeric_limits<std::int64_t>::max();
    std::size_t best_axis = 0;
    std::uint32_t best_bin = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::array<std::int64_t, kBins> right{};
      BvhBox box;
      std::int64_t count = 0;
      for (std::uint32_t b = kBins - 1; b > 0; --b) {
        box.add(bins[axis][b].box);
        count += bins[axis][b].count;
        right[b] = box.half_area() * count;
      }
      box = {};
      count = 0;
      for (std::uint32_t b = 0; b + 1 < kBins; ++b) {
        box.add(bins[axis][b].box);
        count += bins[axis][b].count;
        if (count == 0 || count == static_cast<std::int64_t>(range.size())) continue;
        const std::int64_t cost = box.half_area() * count + right[b + 1];
        if (cost < best_cost) {
          best_cost = cost;
          best_axis = axis;
          best_bin = b;
        }
      }
    }
    const auto second =
        std::ranges::partition(range, [&](const BvhReference& r) { return bin_of(r, best_axis) <= best_bin; });
    return range.size() - second.size();
  }

  void divide(std::uint32_t index, std::size_t begin, std::size_t end, std::uint32_t depth) {
    const Range range = Range(tree_.references).subspan(begin, end - begin);
    BvhBox box;
    for (const BvhReference& r : range) box.add(r.box);
    tree_.nodes[index].box = box;
    if (range.size() == 1) {
      tree_.nodes[index].reference = static_cast<std::uint32_t>(begin);
      return;
    }
    const std::size_t left = split(range, depth);
    const auto child = static_cast<std::uint32_t>(tree_.nodes.size());
    tree_.nodes[index].left = child;
    tree_.nodes.resize(tree_.nodes.size() + 2);
    divide(child, begin, begin + left, depth + 1);
    divide(child + 1, begin + left, end, depth + 1);
  }

  BinaryTree tree_;
};

}  // namespace

BinaryTree build_binned_sah(std::vector<BvhReference> references) {
  ZC_CHECK(!references.empty());
  return Builder(std::move(references)).run();
}

}  // namespace zc
