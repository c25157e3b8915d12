// SPDX-License-Identifier: Apache-2.0
// An index as those see it who use a world: its header, materials and nodes, whether all nodes are in memory or not.
// Borrows; cheap to copy. Threads: any when all nodes are in memory, else one.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "streamer/world_format/node_blocks.h"
#include "streamer/world_format/world_index.h"

namespace zc {

class NodeTable {
 public:
  explicit NodeTable(const decltype(WorldIndex::nodes)& all)
      : all_(all.data()), size_(static_cast<std::uint32_t>(all.size())) {}
  explicit NodeTable(NodeBlocks& blocks) : blocks_(&blocks), size_(blocks.size()) {}

  [[nodiscard]] std::uint32_t size() const { return size_; }
  // Throws IndexFault when it has to be read and cannot be.
  [[nodiscard]] NodeRecord operator[](std::size_t node) const {
    return all_ != nullptr ? all_[node] : blocks_->record(static_cast<std::uint32_t>(node));
  }

 private:
  const NodeRecord* all_ = nullptr;
  NodeBlocks* blocks_ = nullptr;
  std::uint32_t size_;
};

struct IndexView {
  const WorldHeader& header;
  const std::vector<MaterialRecord>& materials;
  const std::string& crs;
  const NodeTable nodes;

  IndexView(const WorldIndex& index)  // NOLINT(google-explicit-constructor): a view of it
      : IndexView(index, NodeTable(index.nodes)) {}
  IndexView(WorldIndex&&) = delete;
  // Of all of `index` but its nodes.
  IndexView(const WorldIndex& index, const NodeTable& table)
      : header(index.header), materials(index.materials), crs(index.crs), nodes(table) {}

  [[nodiscard]] double step_m() const { return lattice_step_m(header); }
};

}  // namespace zc
