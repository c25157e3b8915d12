// SPDX-License-Identifier: Apache-2.0
// Nodes of an index that no cap has room for: they stay in the file and are read in blocks, of which as many are kept
// as there is room for, those that were asked for of late. What comes is what was checked when the world was opened,
// or an IndexFault. Owns: the kept blocks. Threads: one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <string>
#include <vector>

#include "base/result.h"
#include "streamer/world_format/world_index.h"

namespace zc {

// The file no longer gives what it gave when the world was opened. Thrown, for whoever looks at a node cannot go on
// without it; Streamer returns it as an error.
class IndexFault : public std::exception {
 public:
  explicit IndexFault(Error error) : error_(std::move(error)), text_(error_.describe()) {}
  [[nodiscard]] const char* what() const noexcept override { return text_.c_str(); }
  [[nodiscard]] const Error& error() const { return error_; }

 private:
  Error error_;
  std::string text_;
};

class NodeBlocks {
 public:
  static constexpr std::size_t kNodesPerBlock = 64;
  static constexpr std::uint64_t kBlockBytes = kNodesPerBlock * sizeof(NodeRecord);

  // xxh3: of each block of the file, as many as `nodes` have; read: of the file. Keeps room_bytes of blocks, at least
  // one.
  NodeBlocks(std::uint32_t nodes, std::vector<std::uint64_t> xxh3, ReadAt read, std::string path,
             std::uint64_t room_bytes);

  [[nodiscard]] std::uint32_t size() const { return nodes_; }
  // Throws IndexFault.
  [[nodiscard]] NodeRecord record(std::uint32_t node);

  [[nodiscard]] std::uint64_t blocks_read() const { return blocks_read_; }
  // What an object for so many nodes takes.
  [[nodiscard]] static std::uint64_t bytes(std::uint64_t nodes, std::uint64_t room_bytes);

 private:
  [[nodiscard]] std::uint32_t free_slot();
  void fetch(std::uint32_t block, std::uint32_t slot);

  static constexpr std::uint32_t kNone = 0xFFFFFFFF;
  std::uint32_t nodes_;
  std::vector<std::uint64_t> xxh3_;
  ReadAt read_;
  std::string path_;
  std::vector<NodeRecord> kept_;         // kNodesPerBlock per slot
  std::vector<std::uint32_t> slot_of_;   // per block
  std::vector<std::uint32_t> block_of_;  // per slot
  std::vector<std::uint8_t> asked_for_;  // per slot, since the hand last came by
  std::uint32_t hand_ = 0;
  std::uint64_t blocks_read_ = 0;
};

}  // namespace zc
