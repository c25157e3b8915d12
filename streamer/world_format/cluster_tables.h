// SPDX-License-Identifier: Apache-2.0
// What a cluster of a page numbers in 8 bits: its distinct vertices and, in a window of the page's palette, its
// materials or appearances. Numbers go by first use. The baker closes a cluster where one of them is full; the loader
// fills them again. Units: lattice offsets. Threads: one at a time. Untrusted input: nothing is added beyond what 8
// bits number.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "shaders/shared/page.h"

namespace zc {

class ClusterVertices {
 public:
  using Vertex = std::array<std::uint16_t, 3>;

  void clear() {
    vertices_.clear();
    slots_.fill(0);
  }
  [[nodiscard]] const std::vector<Vertex>& vertices() const { return vertices_; }

  // The vertex's number, or nothing when there is no room for it.
  std::optional<std::uint32_t> add(const Vertex& v) {
    const std::uint64_t key = v[0] | std::uint64_t{v[1]} << 16U | std::uint64_t{v[2]} << 32U;
    for (std::size_t slot = (key * 0x9E3779B97F4A7C15ULL) >> 54U;; slot = (slot + 1) % slots_.size()) {
      if (slots_[slot] == 0) {
        if (vertices_.size() == gpu::kClusterMaxVertices) return {};
        vertices_.push_back(v);
        slots_[slot] = static_cast<std::uint16_t>(vertices_.size());
        return vertices_.size() - 1;
      }
      if (vertices_[slots_[slot] - 1] == v) return slots_[slot] - 1;
    }
  }

 private:
  std::vector<Vertex> vertices_;
  std::array<std::uint16_t, 1024> slots_ = {};  // number + 1; at most a quarter full
};

class ClusterPalette {
 public:
  void clear() { entries_.clear(); }
  [[nodiscard]] const std::vector<std::uint16_t>& entries() const { return entries_; }

  // Few and mostly in runs: the last one found is tried first.
  std::optional<std::uint32_t> add(std::uint16_t entry) {
    if (last_ < entries_.size() && entries_[last_] == entry) return last_;
    for (last_ = 0; last_ < entries_.size(); ++last_)
      if (entries_[last_] == entry) return last_;
    if (entries_.size() == gpu::kPaletteMax) return {};
    entries_.push_back(entry);
    return last_;
  }

 private:
  std::vector<std::uint16_t> entries_;
  std::uint32_t last_ = 0;
};

}  // namespace zc
