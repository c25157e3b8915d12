// SPDX-License-Identifier: Apache-2.0
// The cut through the tree that is shown: resident nodes that together cover the whole world exactly once. A node gives
// way to its children when every child is resident or covered below itself, so a page that cannot be read costs detail
// and never a hole. A change costs the tree's depth, the cut its own size, whatever the world's. Threads: one.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "streamer/paging/zeroed_array.h"
#include "streamer/world_format/index_view.h"

namespace zc {

class RenderedCut {
 public:
  // Borrows what the view does; nothing is resident.
  explicit RenderedCut(const IndexView& index);

  // Of a node that is not resident; of one that is.
  void add(std::uint32_t node);
  void remove(std::uint32_t node);

  [[nodiscard]] bool resident(std::uint32_t node) const { return resident_[node] != 0; }
  // Finer pages cover all its ground.
  [[nodiscard]] bool refinable(std::uint32_t node) const;
  [[nodiscard]] bool covered(std::uint32_t node) const { return resident(node) || refinable(node); }
  [[nodiscard]] bool any_child_covered(std::uint32_t node) const { return counts_[node] > 0; }

  // The deepest such cut, sorted by id, into `cut`. The root must be resident.
  void collect(std::vector<std::uint32_t>& cut) const;

  static constexpr std::uint64_t kBytesPerNode = 5;

 private:
  void change_covered(std::uint32_t node, bool to);
  void visit(std::uint32_t node, std::vector<std::uint32_t>& cut) const;

  const IndexView index_;
  ZeroedArray<std::uint8_t> resident_;
  ZeroedArray<std::uint32_t> counts_;  // of covered children
};

}  // namespace zc
