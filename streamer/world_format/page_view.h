// SPDX-License-Identifier: Apache-2.0
// Reads a page that verify_page has passed: the one place in C++ that knows how it keeps nodes and triangles.
// Units: world lattice. Borrows the page. Thread-safe: no state. Untrusted input: none; a page that verify_page did not
// pass may lead out of itself.
#pragma once

#include <algorithm>
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

[[nodiscard]] inline std::uint32_t cluster_vertices(const gpu::ClusterHeader& c) {
  return gpu::cluster_vertices(c.counts);
}
[[nodiscard]] inline std::uint32_t cluster_triangles(const gpu::ClusterHeader& c) {
  return gpu::cluster_triangles(c.counts);
}
[[nodiscard]] inline std::uint32_t cluster_shift(const gpu::ClusterHeader& c) {
  return c.counts >> gpu::kClusterShiftBit;
}
// Words of each part of a cluster; `counts` as in its header.
struct ClusterParts {
  std::uint64_t triangles;  // from the header on
  std::uint64_t light;
  std::uint64_t normals;
  std::uint64_t words;  // with the padding
};
[[nodiscard]] constexpr ClusterParts cluster_parts(std::uint64_t vertices, std::uint64_t triangles,
                                                   std::uint32_t flags) {
  ClusterParts parts{};
  parts.triangles = gpu::kClusterHeaderWords;
  parts.light = (parts.triangles + triangles + (3 * vertices + 1) / 2 + 1) / 2 * 2;
  parts.normals = parts.light + ((flags & gpu::kClusterLight) != 0 ? 2 * triangles : 0);
  const std::uint64_t end = parts.normals + ((flags & gpu::kClusterNormals) != 0 ? 2 * triangles : 0);
  parts.words = (end + gpu::kPageAlignWords - 1) / gpu::kPageAlignWords * gpu::kPageAlignWords;
  return parts;
}

// Of an atlas in a page or a file. Sizes come from anywhere: check before use.
struct AtlasShape {
  std::uint32_t width_log2 = 0;
  std::uint32_t height_log2 = 0;
  std::uint32_t levels = 0;

  [[nodiscard]] static constexpr AtlasShape unpack(std::uint32_t size) {
    return {size & 0xFFU, size >> 8 & 0xFFU, size >> 16};
  }
  [[nodiscard]] constexpr std::uint32_t pack() const { return width_log2 | height_log2 << 8 | levels << 16; }
  // Every level has whole blocks.
  [[nodiscard]] constexpr bool valid() const {
    return width_log2 >= gpu::kAtlasMinLog2 && height_log2 >= gpu::kAtlasMinLog2 && width_log2 <= gpu::kAtlasMaxLog2 &&
           height_log2 <= gpu::kAtlasMaxLog2 && levels >= 1 && levels <= gpu::kAtlasMaxLevels &&
           std::min(width_log2, height_log2) + 1 >= gpu::kAtlasMinLog2 + levels;
  }
  [[nodiscard]] constexpr std::uint32_t level_words(std::uint32_t level) const {
    // Of valid shapes alone. NOLINTNEXTLINE(clang-analyzer-core.UndefinedBinaryOperatorResult)
    return 2U << (width_log2 + height_log2 - 4 - 2 * level);
  }
  [[nodiscard]] constexpr std::uint32_t words() const {
    std::uint32_t sum = 0;
    for (std::uint32_t level = 0; level < levels; ++level) sum += level_words(level);
    return sum;
  }
};

class PageView {
 public:
  using Point = std::array<std::int32_t, 3>;
  struct Triangle {
    std::array<Point, 3> corners;
    std::uint16_t material;
    gpu::Appearance appearance;  // plain where the page has no appearances
  };

  explicit PageView(std::span<const std::uint32_t> page)
      : page_(page), header_(page_record<gpu::PageHeader>(page, 0)) {}

  [[nodiscard]] const gpu::PageHeader& header() const { return header_; }
  [[nodiscard]] gpu::PageNode node(std::uint32_t i) const { return page_record<gpu::PageNode>(page_, node_word(i)); }
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

  // What a page contains only where the zone needs it.
  struct Parts {
    std::uint32_t appearance_bytes = 0;
    std::uint32_t light_bytes = 0;
    std::uint32_t normal_bytes = 0;
    std::uint32_t texture_bytes = 0;
    bool operator==(const Parts&) const = default;
  };
  [[nodiscard]] Parts parts() const {
    Parts parts;
    if ((header_.flags & gpu::kPageAppearances) != 0)
      parts.appearance_bytes = sizeof(gpu::Appearance) * header_.palette_count;
    if (header_.atlas_offset_words != 0) parts.texture_bytes = 4 * AtlasShape::unpack(header_.atlas_size).words();
    for (std::uint32_t c = 0; c < header_.cluster_count; ++c) {
      const auto cluster = page_record<gpu::ClusterHeader>(page_, entry(c).offset_words);
      const auto bytes = static_cast<std::uint32_t>(sizeof(gpu::TriangleLight) * cluster_triangles(cluster));
      if ((cluster.counts & gpu::kClusterLight) != 0) parts.light_bytes += bytes;
      if ((cluster.counts & gpu::kClusterNormals) != 0) parts.normal_bytes += bytes;
    }
    return parts;
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
        out.corners[corner][axis] =
            static_cast<std::int32_t>(origin[axis] + (std::int64_t{offset} << cluster_shift(cluster)));
      }
    }
    const std::size_t palette = at + cluster.palette_words;
    if ((header_.flags & gpu::kPageAppearances) != 0) {
      out.appearance = page_record<gpu::Appearance>(page_, palette + 2 * std::size_t{word >> 24});
      out.material = static_cast<std::uint16_t>(out.appearance.material);
    } else {
      out.material = static_cast<std::uint16_t>(half_word(palette, word >> 24));
      out.appearance.material = out.material;
    }
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
