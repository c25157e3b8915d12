// SPDX-License-Identifier: Apache-2.0
// The cut through the tree that is shown: resident nodes that together cover the whole world exactly once. A node gives
// way to its children when every child is resident or covered below itself, so a page that cannot be read costs detail
// and never a hole. A change costs the tree's depth, the cut its own size, whatever the world's. Threads: one.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "streamer/world_format/world_index.h"
#include "streamer/zeroed_array.h"

namespace zc {

class Cover {
 public:
  // Borrows the index; nothing is resident.
  explicit Cover(const WorldIndex& index);

  // Of a node that is not resident; of one that is.
  void add(std::uint32_t node);
  void remove(std::uint32_t node);

  [[nodiscard]] bool resident(std::uint32_t node) const { return resident_[node] != 0; }
  [[nodiscard]] std::span<const std::uint8_t> resident() const { return resident_.view(); }  // per node: 1 when it is
  [[nodiscard]] std::uint32_t resident_children(std::uint32_t node) const { return counts_[node].resident_children; }

  // The deepest such cut, sorted by id, into `cut`. The root must be resident.
  void collect(std::vector<std::uint32_t>& cut) const;

  static constexpr std::uint64_t kBytesPerNode = 9;

 private:
  struct Counts {
    std::uint32_t resident_children;
    std::uint32_t covered_children;
  };

  [[nodiscard]] bool refinable(std::uint32_t node) const;
  [[nodiscard]] bool covered(std::uint32_t node) const { return resident(node) || refinable(node); }
  void change_covered(std::uint32_t node, bool to);
  void visit(std::uint32_t node, std::vector<std::uint32_t>& cut) const;

  const WorldIndex& index_;
  ZeroedArray<std::uint8_t> resident_;
  ZeroedArray<Counts> counts_;
};

}  // namespace zc
