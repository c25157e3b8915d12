// SPDX-License-Identifier: Apache-2.0
#include "streamer/world_format/node_blocks.h"

#include <xxhash.h>

#include <algorithm>
#include <span>
#include <utility>

#include "base/check.h"

namespace zc {
namespace {

std::uint64_t blocks_of(std::uint64_t nodes) {
  return (nodes + NodeBlocks::kNodesPerBlock - 1) / NodeBlocks::kNodesPerBlock;
}

// A block, whose it is, and whether it was asked for.
constexpr std::uint64_t kSlotBytes = NodeBlocks::kBlockBytes + sizeof(std::uint32_t) + sizeof(std::uint8_t);

std::uint64_t slots_in(std::uint64_t nodes, std::uint64_t room_bytes) {
  return std::clamp<std::uint64_t>(room_bytes / kSlotBytes, 1, blocks_of(nodes));
}

}  // namespace

NodeBlocks::NodeBlocks(std::uint32_t nodes, std::vector<std::uint64_t> xxh3, ReadAt read, std::string path,
                       std::uint64_t room_bytes)
    : nodes_(nodes),
      xxh3_(std::move(xxh3)),
      read_(std::move(read)),
      path_(std::move(path)),
      kept_(slots_in(nodes, room_bytes) * kNodesPerBlock),
      slot_of_(blocks_of(nodes), kNone),
      block_of_(slots_in(nodes, room_bytes), kNone),
      asked_for_(slots_in(nodes, room_bytes)) {
  ZC_CHECK(xxh3_.size() == blocks_of(nodes));
}

std::uint64_t NodeBlocks::bytes(std::uint64_t nodes, std::uint64_t room_bytes) {
  return blocks_of(nodes) * (sizeof(std::uint64_t) + sizeof(std::uint32_t)) + slots_in(nodes, room_bytes) * kSlotBytes;
}

NodeRecord NodeBlocks::record(std::uint32_t node) {
  ZC_CHECK(node < nodes_);
  const auto block = static_cast<std::uint32_t>(node / kNodesPerBlock);
  if (slot_of_[block] == kNone) fetch(block, free_slot());
  asked_for_[slot_of_[block]] = 1;
  return kept_[slot_of_[block] * kNodesPerBlock + node % kNodesPerBlock];
}

// The hand goes round and frees the first block that nobody asked for since it last came by (the CLOCK algorithm).
std::uint32_t NodeBlocks::free_slot() {
  while (true) {
    const std::uint32_t slot = hand_;
    hand_ = static_cast<std::uint32_t>((hand_ + 1) % block_of_.size());
    if (std::exchange(asked_for_[slot], std::uint8_t{0}) != 0) continue;
    if (block_of_[slot] != kNone) slot_of_[std::exchange(block_of_[slot], kNone)] = kNone;
    return slot;
  }
}

void NodeBlocks::fetch(std::uint32_t block, std::uint32_t slot) {
  const std::size_t first = block * kNodesPerBlock;
  const std::span<NodeRecord> records =
      std::span(kept_).subspan(slot * kNodesPerBlock, std::min<std::size_t>(kNodesPerBlock, nodes_ - first));
  const std::uint64_t at = sizeof(WorldHeader) + first * sizeof(NodeRecord);
  if (Status read = read_(at, std::as_writable_bytes(records)); !read.ok()) throw IndexFault(std::move(read).error());
  if (XXH3_64bits(records.data(), records.size_bytes()) != xxh3_[block])
    throw IndexFault({ErrorCode::kFormat, "has changed since the world was opened; open it again", path_,
                      static_cast<std::int64_t>(at)});
  block_of_[slot] = block;
  slot_of_[block] = slot;
  ++blocks_read_;
}

}  // namespace zc
