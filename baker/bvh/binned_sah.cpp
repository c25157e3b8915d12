// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/bvh/binned_sah.h"

#include <bit>

#include "baker/bvh/object_split.h"
#include "base/check.h"

namespace zc {
namespace {

class Builder {
 public:
  explicit Builder(std::span<const BvhReference> references) {
    packed_.reserve(references.size());
    for (const BvhReference& r : references) packed_.emplace_back(r);
    tree_.nodes.reserve(2 * references.size());
  }

  BinaryTree run() {
    tree_.nodes.emplace_back();
    divide(0, packed_, 1);
    tree_.references.reserve(packed_.size());
    for (const PackedBox& r : packed_) tree_.references.push_back(r.reference());
    return std::move(tree_);
  }

 private:
  void divide(std::uint32_t index, std::span<PackedBox> range, std::uint32_t depth) {
    PackedBox box;
    for (const PackedBox& r : range) box.add(r);
    tree_.nodes[index].box = box.box();
    if (range.size() == 1) {
      tree_.nodes[index].reference = static_cast<std::uint32_t>(range.data() - packed_.data());
      return;
    }
    const ObjectSplit split = must_halve(range.size(), depth) ? halve(range) : find_object_split(range);
    apply(split, range);
    const auto child = static_cast<std::uint32_t>(tree_.nodes.size());
    tree_.nodes[index].left = child;
    tree_.nodes.resize(tree_.nodes.size() + 2);
    divide(child, range.first(split.left), depth + 1);
    divide(child + 1, range.subspan(split.left), depth + 1);
  }

  std::vector<PackedBox> packed_;
  BinaryTree tree_;
};

}  // namespace

bool must_halve(std::size_t references, std::uint32_t depth) {
  return depth + static_cast<std::uint32_t>(std::bit_width(references)) >= kBinaryDepthMax;
}

BinaryTree build_binned_sah(std::span<const BvhReference> references) {
  ZC_CHECK(!references.empty());
  return Builder(references).run();
}

}  // namespace zc
