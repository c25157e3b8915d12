// SPDX-License-Identifier: Apache-2.0
// A world's index, wherever the world comes from. Thread-safe: no state, but HeldIndex.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "streamer/source/source.h"
#include "streamer/world_format/index_view.h"
#include "streamer/world_format/node_blocks.h"
#include "streamer/world_format/world_index.h"

namespace zc {

inline constexpr std::uint64_t kIndexBytesMost = 1ULL << 40U;  // 2^32 nodes are fewer

// `place`: of the world, for errors. Fails when the index is larger than limit_bytes.
Result<WorldIndex> read_world_index(Source& source, const std::filesystem::path& place = {},
                                    std::uint64_t limit_bytes = 1ULL << 32U);

// An index under a memory cap: all of it in memory, or all but its nodes, of which some blocks are. Borrows the source.
// Threads: as IndexView.
class HeldIndex {
 public:
  // Checks all of it, once. room_bytes: for the nodes; a source that reads whole files holds all of them whatever that
  // is. Fails with kBudget when opening takes more than limit_bytes.
  static Result<std::unique_ptr<HeldIndex>> open(Source& source, std::uint64_t room_bytes, std::uint64_t limit_bytes);

  [[nodiscard]] IndexView view();
  [[nodiscard]] bool in_memory() const { return !blocks_.has_value(); }
  // Since it was opened, of an index that is not in memory.
  [[nodiscard]] std::uint64_t blocks_read() const { return blocks_ ? blocks_->blocks_read() : 0; }

  // What an index keeps in memory.
  [[nodiscard]] static std::uint64_t bytes(const IndexView& index, std::uint64_t room_bytes, const SourceCosts& source);
  [[nodiscard]] static bool fits(std::uint64_t nodes, std::uint64_t room_bytes, const SourceCosts& source);

 private:
  WorldIndex index_;
  std::unique_ptr<SourceFile> file_;
  std::optional<NodeBlocks> blocks_;
};

}  // namespace zc
