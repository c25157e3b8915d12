// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/bvh/sbvh.h"

#include <vector>

#include "baker/bvh/binned_sah.h"
#include "baker/bvh/object_split.h"
#include "baker/bvh/spatial_split.h"
#include "baker/bvh/sweep_sah.h"
#include "base/check.h"

namespace zc {
namespace {

constexpr std::size_t kCutLeast = 96;  // references from which planes are tried: above, a cut gains most

// The references of the node at hand lie at the end of `stack_`; dividing it leaves its right child's there, then its
// left child's, and a leaf takes its own away.
class Builder {
 public:
  Builder(std::span<const BvhTriangle> triangles, const SbvhOptions& options) : triangles_(triangles) {
    stack_.reserve(2 * triangles.size());
    PackedBox root;
    for (std::uint32_t i = 0; i < triangles.size(); ++i) {
      stack_.emplace_back(BvhReference{box_of(triangles[i]), i});
      root.add(stack_.back());
    }
    const auto root_area = static_cast<double>(root.half_area());
    budget_ = static_cast<std::uint32_t>(static_cast<double>(options.max_duplication) *
                                         static_cast<double>(triangles.size()));
    overlap_least_ = static_cast<std::int64_t>(static_cast<double>(options.alpha) * root_area);
    reference_cost_ = static_cast<std::int64_t>(static_cast<double>(options.reference_cost) * root_area /
                                                static_cast<double>(triangles.size()));
    tree_.nodes.reserve(2 * (triangles.size() + budget_));
    tree_.references.reserve(triangles.size() + budget_);
  }

  BinaryTree run() {
    tree_.nodes.emplace_back();
    divide(0, stack_.size(), 1, budget_);
    return std::move(tree_);
  }

 private:
  // Returns by how many references the subtree has grown: at most `budget`.
  std::uint32_t divide(std::uint32_t index, std::size_t count, std::uint32_t depth, std::uint32_t budget) {
    const std::span<PackedBox> range = std::span(stack_).last(count);
    PackedBox box;
    for (const PackedBox& r : range) box.add(r);
    tree_.nodes[index].box = box.box();
    if (count < kCutLeast) {
      sweep_.grow(tree_, index, range, depth);
      stack_.resize(stack_.size() - count);
      return 0;
    }
    const auto [left, right] = split(range, box, depth, budget);
    const auto added = static_cast<std::uint32_t>(left + right - count);
    const auto child = static_cast<std::uint32_t>(tree_.nodes.size());
    tree_.nodes[index].left = child;
    tree_.nodes.resize(tree_.nodes.size() + 2);
    const std::uint32_t rest = budget - added;
    const auto share = static_cast<std::uint32_t>(std::uint64_t{rest} * left / (left + right));
    const std::uint32_t left_added = divide(child, left, depth + 1, share);
    return added + left_added + divide(child + 1, right, depth + 1, rest - left_added);
  }

  struct Sides {
    std::size_t left = 0;
    std::size_t right = 0;
  };

  Sides split(std::span<PackedBox> range, const PackedBox& box, std::uint32_t depth, std::uint32_t budget) {
    const bool halves = must_halve(range.size(), depth);
    ObjectSplit object = halves ? halve(range) : find_object_split(range);
    if (!halves && budget > 0) {
      PackedBox overlap = object.left_box;
      overlap.clip(object.right_box);
      if (!overlap.empty() && overlap.half_area() > overlap_least_) {
        const SpatialSplit spatial = find_spatial_split(range, box, triangles_);
        if (spatial.cost < object.cost) {
          const std::size_t added = spatial.left + spatial.right - range.size();
          if (added <= budget && spatial.cost + static_cast<std::int64_t>(added) * reference_cost_ < object.cost) {
            const Sides sides = cut(range, spatial);
            if (sides.left > 0) return sides;
          }
        }
      }
    }
    apply(object, range);
    // The left child comes first: its references go to the end.
    scratch_.assign(range.begin(), range.begin() + static_cast<std::ptrdiff_t>(object.left));
    std::copy(range.begin() + static_cast<std::ptrdiff_t>(object.left), range.end(), range.begin());
    std::copy(scratch_.begin(), scratch_.end(), range.end() - static_cast<std::ptrdiff_t>(object.left));
    return {object.left, range.size() - object.left};
  }

  [[nodiscard]] PackedBox piece(const PackedBox& r, std::size_t axis, std::uint32_t low, std::uint32_t high) const {
    PackedBox box = slab_box(triangles_[r.triangle()], axis, low, high);
    box.clip(r);
    return box;
  }

  // Leaves the range as it was and returns nothing when one side would be empty.
  Sides cut(std::span<PackedBox> range, const SpatialSplit& split) {
    left_.clear();
    right_.clear();
    PackedBox left_box = split.left_box;
    PackedBox right_box = split.right_box;
    auto left = static_cast<std::int64_t>(split.left);
    auto right = static_cast<std::int64_t>(split.right);
    for (const PackedBox& r : range) {
      Side side = side_of(r, split);
      if (side == Side::kBoth) {
        const PackedBox left_piece = piece(r, split.axis, r.min(split.axis), split.plane);
        const PackedBox right_piece = piece(r, split.axis, split.plane, r.max(split.axis));
        PackedBox with_left = left_box;
        with_left.add(r);
        PackedBox with_right = right_box;
        with_right.add(r);
        const std::int64_t both_cost = left_box.area() * left + right_box.area() * right + reference_cost_;
        const std::int64_t left_cost = with_left.area() * left + right_box.area() * (right - 1);
        const std::int64_t right_cost = left_box.area() * (left - 1) + with_right.area() * right;
        if (right_piece.empty() || (left_cost <= both_cost && left_cost <= right_cost)) {
          side = Side::kLeft;
          left_box = with_left;
          --right;
        } else if (left_piece.empty() || right_cost <= both_cost) {
          side = Side::kRight;
          right_box = with_right;
          --left;
        } else {
          left_.emplace_back(BvhReference{left_piece.box(), r.triangle()});
          right_.emplace_back(BvhReference{right_piece.box(), r.triangle()});
          continue;
        }
      }
      (side == Side::kLeft ? left_ : right_).push_back(r);
    }
    if (left_.empty() || right_.empty()) return {};
    stack_.resize(stack_.size() - range.size());
    stack_.insert(stack_.end(), right_.begin(), right_.end());
    stack_.insert(stack_.end(), left_.begin(), left_.end());
    return {left_.size(), right_.size()};
  }

  std::span<const BvhTriangle> triangles_;
  std::vector<PackedBox> stack_;
  std::vector<PackedBox> scratch_, left_, right_;
  SweepBuilder sweep_;
  std::uint32_t budget_ = 0;
  std::int64_t overlap_least_ = 0;
  std::int64_t reference_cost_ = 0;
  BinaryTree tree_;
};

}  // namespace

BinaryTree build_sbvh(std::span<const BvhTriangle> triangles, const SbvhOptions& options) {
  ZC_CHECK(!triangles.empty() && options.max_duplication >= 0);
  return Builder(triangles, options).run();
}

}  // namespace zc
