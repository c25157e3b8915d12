// SPDX-License-Identifier: Apache-2.0
// Walks everything in a page that a traversal and a shading pass could ever reach, in the shaders' own arithmetic of
// 32-bit words, and says what they would read outside the page: the truth that verify_page is held against. It shares
// no code with the check. Thread-safe: no state.
#pragma once

#include <bit>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "shaders/shared/page.h"

namespace zc::test {

class PageAudit {
 public:
  // `base`: the page's first word in the pool.
  PageAudit(std::span<const std::uint32_t> page, std::uint32_t base, std::uint32_t material_count)
      : page_(page), base_(base), material_count_(material_count) {}

  // Nothing, or what is wrong.
  std::optional<std::string> run() {
    walk_tree();
    if (fault_.empty()) look_up_triangles();
    return fault_.empty() ? std::nullopt : std::optional(fault_);
  }

 private:
  std::uint32_t read(std::uint32_t word, const char* what) {
    const std::uint32_t from = word - base_;
    if (from < page_.size()) return page_[from];
    if (fault_.empty()) fault_ = std::string(what) + " outside the page, at its word " + std::to_string(from);
    return 0;
  }

  // traverse.glsl: every child of every node, whatever the boxes.
  void walk_tree() {
    struct Visit {
      std::uint32_t word;
      std::uint32_t depth;
    };
    std::vector<Visit> stack = {{base_ + gpu::kPageHeaderWords, 1}};
    const std::uint32_t depth = read(base_ + 8, "header");
    for (std::uint32_t visits = 0; !stack.empty() && fault_.empty(); ++visits) {
      if (visits > page_.size()) fault_ = "the tree does not end";
      const Visit at = stack.back();
      stack.pop_back();
      if (at.depth > depth) fault_ = "deeper than the header says";
      if ((at.word - base_) % gpu::kPageAlignWords != 0) fault_ = "a node is not aligned";
      for (std::uint32_t i = 0; i < gpu::kPageNodeWords; ++i) read(at.word + i, "node");
      if (!fault_.empty()) return;
      const std::uint32_t masks = read(at.word + 3, "node") >> 16;
      const std::uint32_t counts = read(at.word + 6, "node");
      const auto children = static_cast<std::uint32_t>(std::popcount(masks & 0xFFU));
      for (std::uint32_t c = 0; c < children; ++c)
        stack.push_back({at.word + read(at.word + 4, "node") + c * gpu::kPageNodeWords, at.depth + 1});
      if (masks >> 8 == 0) continue;
      const std::uint32_t cluster = at.word + read(at.word + 7, "node");
      std::uint32_t triangle = at.word + read(at.word + 5, "node");
      for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
        const std::uint32_t count = counts >> (4 * slot) & 15U;
        for (std::uint32_t k = 0; k < count; ++k)
          if ((masks >> (8 + slot) & 1U) != 0) read_triangle(cluster, triangle + k);
        triangle += count;
      }
    }
  }

  void read_triangle(std::uint32_t cluster, std::uint32_t triangle) {
    if ((cluster - base_) % gpu::kPageAlignWords != 0) fault_ = "a cluster is not aligned";
    for (std::uint32_t i = 0; i < gpu::kClusterHeaderWords; ++i) read(cluster + i, "cluster");
    const std::uint32_t vertices = cluster + gpu::kClusterHeaderWords + (read(cluster + 3, "cluster") >> 9 & 0x3FFU);
    const std::uint32_t corners = read(triangle, "triangle");
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t first = vertices + (3 * (corners >> (8 * k) & 0xFFU)) / 2;
      read(first, "vertex");
      read(first + 1, "vertex");
    }
    // What the hit record says must lead back here.
    if (cluster - read(cluster + 5, "cluster") != base_) fault_ = "a hit names another page";
    const std::uint32_t position = read(cluster + 6, "cluster") + triangle - cluster - gpu::kClusterHeaderWords;
    if (position >= read(base_ + 3, "header")) fault_ = "a hit names a triangle that is not there";
  }

  // fetch_triangle in page_fetch.glsl.
  void look_up_triangles() {
    const std::uint32_t triangles = read(base_ + 3, "header");
    for (std::uint32_t t = 0; t < triangles && fault_.empty(); ++t) {
      std::uint32_t low = base_ + read(base_ + 5, "header");
      for (std::uint32_t count = read(base_ + 4, "header"); count > 1;) {
        const std::uint32_t half = count >> 1;
        const std::uint32_t middle = low + half * gpu::kClusterEntryWords;
        low = read(middle, "entry") <= t ? middle : low;
        count -= half;
      }
      const std::uint32_t cluster = base_ + read(low + 1, "entry");
      const std::uint32_t triangle = cluster + gpu::kClusterHeaderWords + t - read(cluster + 6, "cluster");
      read_triangle(cluster, triangle);
      const std::uint32_t place = read(triangle, "triangle") >> 24;
      const std::uint32_t palette = cluster + read(cluster + 7, "cluster");
      const bool appearances = (read(base_ + 1, "header") & gpu::kPageAppearances) != 0;
      const std::uint32_t material = appearances
                                         ? read(palette + 2 * place, "palette") & 0xFFFFU
                                         : read(palette + (place >> 1), "palette") >> (16 * (place & 1U)) & 0xFFFFU;
      if (appearances) read(palette + 2 * place + 1, "palette");
      if (material >= material_count_) fault_ = "a material that is not there";
    }
  }

  std::span<const std::uint32_t> page_;
  std::uint32_t base_;
  std::uint32_t material_count_;
  std::string fault_;
};

}  // namespace zc::test
