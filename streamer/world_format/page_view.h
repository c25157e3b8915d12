// SPDX-License-Identifier: Apache-2.0
// Reads a page that verify_page has passed: the one place in C++ that knows how it keeps nodes and triangles.
// Units: world lattice. Borrows the page. Thread-safe: no state.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <span>

#include "shaders/shared/page.h"

namespace zc {

template <class Record>
[[nodiscard]] Record page_record(std::span<const std::uint32_t> page, std::size_t word) {
  Record record;
  std::memcpy(&record, page.subspan(word, sizeof record / sizeof(std::uint32_t)).data(), sizeof record);
  return record;
}

[[nodiscard]] inline std::uint32_t cluster_vertices(const gpu::ClusterHeader& c) { return c.counts & 0x1FFU; }
[[nodiscard]] inline std::uint32_t cluster_triangles(const gpu::ClusterHeader& c) { return c.counts >> 9 & 0x3FFFFU; }
[[nodiscard]] inline std::uint32_t cluster_shift(const gpu::ClusterHeader& c) { return c.counts >> 27; }
// Words of a cluster, with its padding.
[[nodiscard]] constexpr std::uint64_t cluster_words(std::uint64_t vertices, std::uint64_t triangles) {
  const std::uint64_t words = gpu::kClusterHeaderWords + triangles + (3 * vertices + 1) / 2;
  return (words + gpu::kPageAlignWords - 1) / gpu::kPageAlignWords * gpu::kPageAlignWords;
}

class PageView {
 public:
  using Point = std::array<std::int32_t, 3>;
  struct Triangle {
    std::array<Point, 3> corners;
    std::uint16_t material;
  };

  explicit PageView(std::span<const std::uint32_t> page)
      : page_(page), header_(page_record<gpu::PageHeader>(page, 0)) {}

  [[nodiscard]] const gpu::PageHeader& header() const { return header_; }
  [[nodiscard]] gpu::PageNode node(std::uint32_t i) const {
    return page_record<gpu::PageNode>(page_, node_word(i));
  }
  [[nodiscard]] static std::size_t node_word(std::uint32_t i) {
    return gpu::kPageHeaderWords + std::size_t{i} * gpu::kPageNodeWords;
  }
  [[nodiscard]] gpu::ClusterEntry entry(std::uint32_t i) const {
    return page_record<gpu::ClusterEntry>(page_,
                                          header_.entries_offset_words + std::size_t{i} * gpu::kClusterEntryWords);
  }
  // The position of the first triangle in the leaves of a node that has some.
  [[nodiscard]] std::uint32_t first_triangle(std::uint32_t i) const {
    const gpu::PageNode n = node(i);
    const auto cluster = page_record<gpu::ClusterHeader>(page_, node_word(i) + n.cluster_offset);
    return cluster.first_triangle + n.triangle_offset - n.cluster_offset - gpu::kClusterHeaderWords;
  }

  [[nodiscard]] Triangle triangle(std::uint32_t position) const {
    std::uint32_t low = 0;
    for (std::uint32_t count = header_.cluster_count; count > 1;) {  // the last entry that is not behind `position`
      const std::uint32_t half = count / 2;
      if (entry(low + half).first_triangle <= position) low += half;
      count -= half;
    }
    const std::size_t at = entry(low).offset_words;
    const auto cluster = page_record<gpu::ClusterHeader>(page_, at);
    const std::size_t triangles = at + gpu::kClusterHeaderWords;
    const std::size_t vertices = triangles + cluster_triangles(cluster);
    const std::uint32_t word = page_[triangles + position - cluster.first_triangle];
    Triangle out{};
    const Point origin = {cluster.origin_x, cluster.origin_y, cluster.origin_z};
    for (std::size_t corner = 0; corner < 3; ++corner) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::uint32_t offset = half_word(vertices, 3 * (word >> (8 * corner) & 0xFFU) + axis);
        out.corners[corner][axis] = static_cast<std::int32_t>(origin[axis] + (std::int64_t{offset} << cluster_shift(cluster)));
      }
    }
    out.material = static_cast<std::uint16_t>(half_word(at + cluster.palette_words, word >> 24));
    return out;
  }

 private:
  [[nodiscard]] std::uint32_t half_word(std::size_t word, std::size_t i) const {
    return page_[word + i / 2] >> (16 * (i % 2)) & 0xFFFFU;
  }

  std::span<const std::uint32_t> page_;
  gpu::PageHeader header_;
};

}  // namespace zc
