// SPDX-License-Identifier: Apache-2.0
#include "streamer/source/index_file.h"

#include <string>
#include <utility>

namespace zc {
namespace {

ReadAt reader_of(const SourceFile& file) {
  return [&file](std::uint64_t offset, std::span<std::byte> out) { return file.read(offset, out); };
}

}  // namespace

Result<WorldIndex> read_world_index(Source& source, const std::filesystem::path& place, std::uint64_t limit_bytes) {
  ZC_ASSIGN(const std::unique_ptr<SourceFile> file, source.open(kWorldIndexName, limit_bytes));
  return decode_world_index(file->size_bytes(), reader_of(*file), (place / kWorldIndexName).string());
}

bool HeldIndex::fits(std::uint64_t nodes, std::uint64_t room_bytes, const SourceCosts& source) {
  return source.whole_files || nodes * sizeof(NodeRecord) <= room_bytes;
}

std::uint64_t HeldIndex::bytes(const IndexView& index, std::uint64_t room_bytes, const SourceCosts& source) {
  const std::uint64_t nodes = index.nodes.size();
  return sizeof(WorldIndex) + index.materials.size() * sizeof(MaterialRecord) + index.crs.size() +
         (fits(nodes, room_bytes, source) ? nodes * sizeof(NodeRecord) : NodeBlocks::bytes(nodes, room_bytes));
}

Result<std::unique_ptr<HeldIndex>> HeldIndex::open(Source& source, std::uint64_t room_bytes,
                                                   std::uint64_t limit_bytes) {
  const SourceCosts costs = source.costs();
  auto held = std::make_unique<HeldIndex>();
  ZC_ASSIGN(held->file_, source.open(kWorldIndexName, costs.whole_files ? limit_bytes : kIndexBytesMost));
  const ReadAt read = reader_of(*held->file_);
  const std::uint64_t file_bytes = held->file_->size_bytes();
  ZC_ASSIGN(const WorldHeader header, read_world_header(file_bytes, read, kWorldIndexName));
  if (fits(header.node_count, room_bytes, costs)) {
    ZC_ASSIGN(held->index_, decode_world_index(file_bytes, read, kWorldIndexName));
    held->file_.reset();
    return held;
  }
  if (const std::uint64_t takes = check_index_bytes(header.node_count) + header.crs_bytes; takes > limit_bytes)
    return Error{ErrorCode::kBudget,
                 "its " + std::to_string(header.node_count) + " nodes take " + std::to_string(takes) +
                     " bytes to be checked: use a larger cap, of more than that",
                 kWorldIndexName};
  ZC_ASSIGN(IndexInFile checked, check_world_index(file_bytes, read, NodeBlocks::kNodesPerBlock, kWorldIndexName));
  held->index_ = std::move(checked.index);
  held->blocks_.emplace(header.node_count, std::move(checked.block_xxh3), read, kWorldIndexName, room_bytes);
  return held;
}

IndexView HeldIndex::view() { return blocks_ ? IndexView(index_, NodeTable(*blocks_)) : IndexView(index_); }

}  // namespace zc
