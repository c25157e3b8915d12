// SPDX-License-Identifier: Apache-2.0
// Damages GPU pages in the ways that files, memory and attackers do: bits, words, references, nodes and sizes, alone
// and several at once, and whole pages of noise. The same seed gives the same damage everywhere. Borrows the pages.
// Threads: one at a time.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <random>
#include <span>
#include <string_view>
#include <vector>

#include "streamer/world_format/page_view.h"

namespace zc::test {

enum class Damage : std::uint8_t {
  kHeaderBit,
  kNodeBit,
  kClusterBit,
  kTriangleBit,
  kVertexBit,
  kTableBit,
  kAnyBit,  // tables: entries and palette
  kHeaderWord,
  kReferenceWord,
  kAnyWord,  // a value that is often mishandled
  kReferenceByOne,
  kHeaderByOne,
  kSwapNodes,
  kSwapTriangles,
  kSwapWords,
  kCopyChild,
  kCycle,
  kGrowBox,
  kMarkSplit,
  kOtherPage,
  kNoise,
  kCut,
  kExtend,
  kCount  // from here on nothing else is left to damage, or its places have moved
};

inline constexpr std::array<std::string_view, static_cast<std::size_t>(Damage::kCount)> kDamageNames = {
    "header bit",
    "node bit",
    "cluster header bit",
    "triangle bit",
    "vertex bit",
    "table bit",
    "any bit",
    "header word",
    "reference word",
    "any word",
    "reference by one",
    "header by one",
    "nodes swapped",
    "triangles swapped",
    "words swapped",
    "child copied",
    "cycle",
    "box grown",
    "marked as split",
    "part of another page",
    "noise",
    "cut",
    "extended"};

class PageCorruption {
 public:
  struct Page {
    std::size_t source = 0;  // which page it was
    Damage damage = Damage::kAnyBit;
    std::vector<std::uint32_t> words;
  };

  PageCorruption(std::span<const std::vector<std::uint32_t>> pages, std::uint64_t seed)
      : pages_(pages), random_(seed) {}

  // Never the page as it was: damage that does nothing, such as the swap of two equal words, is not counted.
  Page next() {
    Page page = damaged();
    while (page.words == pages_[page.source]) page = damaged();
    return page;
  }

 private:
  struct Range {
    std::size_t first = 0;
    std::size_t count = 0;
  };

  Page damaged() {
    Page page;
    page.source = below(pages_.size());
    page.damage = static_cast<Damage>(below(static_cast<std::size_t>(Damage::kCount)));
    page.words = pages_[page.source];
    read_layout(page.words);
    // Three faults in four come alone.
    for (std::size_t more = below(4) != 0 ? 0 : 1 + below(3); more > 0; --more)
      apply(static_cast<Damage>(below(static_cast<std::size_t>(Damage::kNoise))), page.words);
    apply(page.damage, page.words);
    page.words.shrink_to_fit();  // so that a sanitizer sees every read past the end
    return page;
  }

  std::size_t below(std::size_t n) { return n == 0 ? 0 : static_cast<std::size_t>(random_() % n); }
  std::uint32_t* at(std::vector<std::uint32_t>& page, const Range& range) {
    return &page[range.first + below(range.count)];
  }
  void flip(std::uint32_t* word) { *word ^= 1U << below(32); }
  std::uint32_t awkward() {
    constexpr std::array<std::uint32_t, 12> values = {0,     1,      2,          3,          0x7F,       0xFF,
                                                      0x100, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFE, 0xFFFFFFFF};
    return values[below(values.size())];
  }
  std::uint32_t one_off(std::uint32_t unit) { return below(2) == 0 ? unit : 0 - unit; }

  void read_layout(const std::vector<std::uint32_t>& page) {
    const PageView view(page);
    header_ = view.header();
    clusters_.clear();
    triangles_.clear();
    vertices_.clear();
    for (std::uint32_t c = 0; c < header_.cluster_count; ++c) {
      const std::size_t word = view.entry(c).offset_words;
      const auto cluster = page_record<gpu::ClusterHeader>(page, word);
      clusters_.push_back({word, gpu::kClusterHeaderWords});
      triangles_.push_back({word + gpu::kClusterHeaderWords, cluster_triangles(cluster)});
      vertices_.push_back({triangles_.back().first + triangles_.back().count, (3 * cluster_vertices(cluster) + 1) / 2});
    }
  }
  std::size_t any_node() { return PageView::node_word(static_cast<std::uint32_t>(below(header_.node_count))); }
  // child_offset, triangle_offset, leaf_counts or cluster_offset of a node, or a cluster's reference.
  Range reference() {
    if (below(4) == 0) {
      constexpr std::array<std::size_t, 4> fields = {3, 5, 6, 7};
      const std::size_t cluster = clusters_[below(clusters_.size())].first;
      return {cluster + fields[below(fields.size())], 1};
    }
    const std::size_t node = any_node();
    return {node + 4 + below(4), 1};
  }

  void apply(Damage damage, std::vector<std::uint32_t>& page) {
    const Range header = {0, gpu::kPageHeaderWords};
    const Range all = {0, page.size()};
    switch (damage) {
      case Damage::kHeaderBit:
        return flip(at(page, header));
      case Damage::kNodeBit:
        return flip(at(page, {any_node(), gpu::kPageNodeWords}));
      case Damage::kClusterBit:
        return flip(at(page, clusters_[below(clusters_.size())]));
      case Damage::kTriangleBit:
        return flip(at(page, triangles_[below(triangles_.size())]));
      case Damage::kVertexBit:
        return flip(at(page, vertices_[below(vertices_.size())]));
      case Damage::kTableBit:
        return flip(at(page, {header_.entries_offset_words, header_.total_words - header_.entries_offset_words}));
      case Damage::kAnyBit:
        return flip(at(page, all));
      case Damage::kHeaderWord:
        *at(page, header) = awkward();
        return;
      case Damage::kReferenceWord:
        *at(page, reference()) = awkward();
        return;
      case Damage::kAnyWord:
        *at(page, all) = awkward();
        return;
      case Damage::kReferenceByOne:
        *at(page, reference()) += one_off(below(2) == 0 ? 1 : gpu::kPageNodeWords);
        return;
      case Damage::kHeaderByOne:
        *at(page, {1, 9}) += one_off(1);
        return;
      case Damage::kSwapNodes:
        return swap_nodes(page);
      case Damage::kSwapTriangles: {
        const Range range = triangles_[below(triangles_.size())];
        std::swap(*at(page, range), *at(page, range));
        return;
      }
      case Damage::kSwapWords:
        std::swap(*at(page, all), *at(page, all));
        return;
      case Damage::kCopyChild:
        return copy_child(page);
      case Damage::kCycle:
        return close_cycle(page);
      case Damage::kGrowBox:
        return grow_box(page);
      case Damage::kMarkSplit:
        page[1] |= gpu::kPageSplitTriangles;
        return flip(at(page, {any_node() + 8, 12}));
      case Damage::kCut:
        return resize(page, below(2) == 0 ? below(page.size()) : page.size() - 1 - below(8));  // pages are longer
      case Damage::kExtend:
        return resize(page, page.size() + 1 + below(64));
      case Damage::kOtherPage: {
        const std::vector<std::uint32_t>& other = pages_[below(pages_.size())];
        const std::size_t first = below(std::min(page.size(), other.size()));
        const std::size_t count = 1 + below(std::min<std::size_t>({64, page.size() - first, other.size() - first}));
        std::copy_n(other.begin() + static_cast<std::ptrdiff_t>(first), count,
                    page.begin() + static_cast<std::ptrdiff_t>(first));
        return;
      }
      case Damage::kNoise:
        // In half of them the header stays, so that the check looks further.
        for (std::size_t i = below(2) == 0 ? 0 : gpu::kPageHeaderWords; i < page.size(); ++i)
          page[i] = static_cast<std::uint32_t>(random_());
        return;
      case Damage::kCount:
        return;
    }
  }

  // Now and then with a size in the header that fits.
  void resize(std::vector<std::uint32_t>& page, std::size_t words) {
    page.resize(words, static_cast<std::uint32_t>(random_()));
    if (page.size() > 9 && below(2) == 0) page[9] = static_cast<std::uint32_t>(page.size());
  }

  void swap_nodes(std::vector<std::uint32_t>& page) {
    const std::size_t a = any_node();
    const std::size_t b = any_node();
    // Whole nodes, or only where they lead.
    const std::size_t skip = below(2) == 0 ? 0 : 4;
    const std::size_t end = skip == 0 ? gpu::kPageNodeWords : 8;
    for (std::size_t i = skip; i < end; ++i) std::swap(page[a + i], page[b + i]);
  }

  // A second reference to nodes that have a parent already.
  void copy_child(std::vector<std::uint32_t>& page) {
    const std::size_t a = any_node();
    const std::size_t b = any_node();
    const std::uint32_t child = static_cast<std::uint32_t>(a) + page[a + 4];
    page[b + 4] = child - static_cast<std::uint32_t>(b);
    if (below(2) == 0) page[b + 3] = page[a + 3];
  }

  void close_cycle(std::vector<std::uint32_t>& page) {
    const std::size_t a = any_node();
    const std::size_t b = any_node();
    page[a + 4] = static_cast<std::uint32_t>(b) - static_cast<std::uint32_t>(a);
  }

  // Outwards, which is sound as long as the parent's box has room.
  void grow_box(std::vector<std::uint32_t>& page) {
    const std::size_t plane = below(12);
    const std::size_t slot = below(4);
    std::uint32_t& word = page[any_node() + 8 + plane];
    const std::uint32_t byte = word >> (8 * slot) & 0xFFU;
    if (plane < 6 ? byte == 0 : byte == 255) return;
    word += (plane < 6 ? 0U - 1U : 1U) << (8 * slot);
  }

  std::span<const std::vector<std::uint32_t>> pages_;
  std::mt19937_64 random_;
  gpu::PageHeader header_ = {};
  std::vector<Range> clusters_, triangles_, vertices_;
};

}  // namespace zc::test
