// SPDX-License-Identifier: Apache-2.0
#include "runtime/scene/top_level.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <map>
#include <random>
#include <vector>

namespace zc {
namespace {

// Pages of two levels in one pool: a root with some leaves of one triangle and some children, which hold a leaf each.
// A triangle is just its word.
class Pool {
 public:
  void add_page(const NodeBox& box, std::uint32_t leaves, std::uint32_t inner, std::mt19937& random) {
    const auto page_word = static_cast<std::uint32_t>(words_.size());
    const std::uint32_t node_count = 1 + inner;
    words_.resize(page_word + gpu::kPageHeaderWords + node_count * gpu::kPageNodeWords + 16);
    gpu::PageHeader header{};
    header.node_count = node_count;
    header.depth = inner > 0 ? 2 : 1;
    header.triangle_count = leaves + inner;
    std::memcpy(words_.data() + page_word, &header, sizeof header);
    std::array<NodeBox, gpu::kNodeWidth> boxes;
    for (std::uint32_t i = 0; i < leaves + inner; ++i) {
      for (std::size_t a = 0; a < 3; ++a) {
        const auto extent = static_cast<std::uint32_t>(box.max[a] - box.min[a]) + 1;
        boxes[i].min[a] = box.min[a] + static_cast<std::int32_t>(random() % extent);
        boxes[i].max[a] =
            boxes[i].min[a] +
            static_cast<std::int32_t>(random() % static_cast<std::uint32_t>(box.max[a] - boxes[i].min[a] + 1));
      }
    }
    const std::uint32_t triangles = page_word + gpu::kPageHeaderWords + node_count * gpu::kPageNodeWords;
    const std::uint32_t root_word = page_word + gpu::kPageHeaderWords;
    gpu::PageNode root = pack_boxes(boxes);
    root.exponents_masks |= ((1U << leaves) - 1) << 24 | ((1U << inner) - 1) << (16 + leaves);
    for (std::uint32_t i = 0; i < leaves; ++i) root.leaf_counts |= 1U << (4 * i);
    root.child_offset = gpu::kPageNodeWords;
    root.triangle_offset = root.cluster_offset = triangles - root_word;
    put(root_word, root);
    for (std::uint32_t i = 0; i < inner; ++i) {
      const std::uint32_t word = root_word + (1 + i) * gpu::kPageNodeWords;
      gpu::PageNode child = pack_boxes({boxes[leaves + i], {}, {}, {}, {}, {}, {}, {}});
      child.exponents_masks |= 1U << 24;
      child.leaf_counts = 1;
      child.triangle_offset = child.cluster_offset = triangles + leaves + i - word;
      put(word, child);
    }
    for (std::uint32_t i = 0; i < leaves + inner; ++i) expected_[triangles + i] = 1;
    page_words_.push_back(page_word);
  }

  // Builds the top level behind the pages and follows every reference.
  void expect_sound() {
    const std::vector<std::uint32_t> pool = words_;
    std::vector<PageRoot> roots;
    for (const std::uint32_t word : page_words_) roots.push_back(page_root(std::span(words_).subspan(word)));
    std::vector<TracedPage> pages;
    for (std::size_t i = 0; i < roots.size(); ++i)
      pages.push_back(
          traced_page(page_words_[i], roots[i], std::as_bytes(std::span(pool)).data() + 4 * page_words_[i]));
    const auto first = static_cast<std::uint32_t>((words_.size() + 3) / 4 * 4);
    TopLevelBuilder top;
    top.build(pages, first);
    // As every builder does, whatever it has built before.
    TopLevelBuilder other;
    other.build(std::span(pages).first(pages.size() / 2), 4 * first);
    other.build(pages, first);
    ASSERT_EQ(other.nodes().size(), top.nodes().size());
    EXPECT_EQ(std::memcmp(other.nodes().data(), top.nodes().data(), top.nodes().size_bytes()), 0);
    EXPECT_EQ(other.depth(), top.depth());
    const auto count = static_cast<std::uint32_t>(pages.size());
    EXPECT_LE(top.nodes().size(), top_level_node_bound(count));
    words_.resize(first + top.nodes().size() * gpu::kPageNodeWords);
    top_leaves_ = 0;
    for (std::uint32_t i = 0; i < top.nodes().size(); ++i) {
      const gpu::PageNode& node = top.nodes()[i];
      const bool leads_on = inner_mask(node) != 0 && first + i * gpu::kPageNodeWords + node.child_offset >= first;
      top_leaves_ += leads_on || pages.empty() ? 0 : 1;
    }
    for (std::uint32_t i = 0; i < top.nodes().size(); ++i) put(first + i * gpu::kPageNodeWords, top.nodes()[i]);
    found_.clear();
    deepest_ = 0;
    visit(first, 1);
    EXPECT_EQ(found_, expected_);
    if (!pages.empty()) {
      EXPECT_EQ(deepest_, top.depth());
    }
    EXPECT_LE(top.depth(), top_level_depth_bound(count) + 2);
  }

  // Copies of pages' nodes in the top level, after expect_sound.
  [[nodiscard]] std::uint32_t top_leaves() const { return top_leaves_; }

 private:
  void put(std::uint32_t word, const gpu::PageNode& node) { std::memcpy(words_.data() + word, &node, sizeof node); }

  void visit(std::uint32_t word, std::uint32_t depth) {
    ASSERT_LE(word + gpu::kPageNodeWords, words_.size());
    deepest_ = std::max(deepest_, depth);
    gpu::PageNode node;
    std::memcpy(&node, words_.data() + word, sizeof node);
    ASSERT_EQ(inner_mask(node) & leaf_mask(node), 0U);
    std::uint32_t child = word + node.child_offset;
    std::uint32_t triangle = word + node.triangle_offset;
    for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
      if ((leaf_mask(node) >> slot & 1U) != 0) ++found_[triangle];
      triangle += leaf_count(node, slot);
      if ((inner_mask(node) >> slot & 1U) == 0) continue;
      ASSERT_LE(child + gpu::kPageNodeWords, words_.size());
      const WideNodeBox outer = child_box(node, slot);
      gpu::PageNode below;
      std::memcpy(&below, words_.data() + child, sizeof below);
      for (std::uint32_t s = 0; s < gpu::kNodeWidth; ++s) {
        if (((inner_mask(below) | leaf_mask(below)) >> s & 1U) == 0) continue;
        const WideNodeBox inner = child_box(below, s);
        for (std::size_t a = 0; a < 3; ++a) {
          EXPECT_LE(outer.min[a], inner.min[a]);
          EXPECT_GE(outer.max[a], inner.max[a]);
        }
      }
      visit(child, depth + 1);
      child += gpu::kPageNodeWords;
    }
  }

  std::vector<std::uint32_t> words_;
  std::vector<std::uint32_t> page_words_;
  std::map<std::uint32_t, int> expected_, found_;
  std::uint32_t deepest_ = 0;
  std::uint32_t top_leaves_ = 0;
};

NodeBox random_box(std::mt19937& random, std::uint32_t spread, std::uint32_t size) {
  NodeBox box;
  for (std::size_t a = 0; a < 3; ++a) {
    box.min[a] = static_cast<std::int32_t>(random() % spread) - static_cast<std::int32_t>(spread / 2);
    box.max[a] = box.min[a] + static_cast<std::int32_t>(random() % size);
  }
  return box;
}

TEST(TopLevel, ReachesEveryTriangleOfEveryPageOnceWithinItsBoxes) {
  for (const std::uint32_t count : {0U, 1U, 2U, 3U, 9U, 17U, 500U}) {
    std::mt19937 random(count + 1);
    Pool pool;
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto leaves = static_cast<std::uint32_t>(random() % 5);
      const auto inner = static_cast<std::uint32_t>(random() % (9 - leaves));
      pool.add_page(random_box(random, 2000000, 60000), leaves + inner == 0 ? 1 : leaves, inner, random);
    }
    pool.expect_sound();
  }
}

// Two pages across each other: the top level sorts their parts, so that most of what it leads to is of one half.
TEST(TopLevel, OpensLargePagesAndNoMoreThanItHasRoomFor) {
  std::mt19937 random(5);
  for (const std::uint32_t count : {1U, 2U, 30U, 200U}) {
    Pool pool;
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto size = static_cast<std::int32_t>(i % 10 == 0 ? 100000 : 100);
      pool.add_page({{0, 0, 0}, {size, size, size}}, 2, 6, random);
    }
    pool.expect_sound();
    // An opened page has six parts and what is left of its root.
    const std::uint32_t opened = (pool.top_leaves() - count) / 6;
    EXPECT_EQ(pool.top_leaves(), count + 6 * opened);
    EXPECT_EQ(opened, count == 1 ? 0 : std::min(count, (count / 2 + 8) / 6));
  }
}

TEST(TopLevel, StaysShallowWhereAllPagesCoincideOrOneIsHuge) {
  std::mt19937 random(7);
  Pool same;
  for (int i = 0; i < 1000; ++i) same.add_page({{0, 0, 0}, {10, 10, 10}}, 2, 6, random);
  same.expect_sound();
  Pool nested;  // each lies in all that are larger
  for (int i = 0; i < 30; ++i) nested.add_page({{0, 0, 0}, {1 << i, 1 << i, 1 << i}}, 1, 7, random);
  nested.expect_sound();
}

}  // namespace
}  // namespace zc
