// SPDX-License-Identifier: Apache-2.0
#include "runtime/scene/transfers.h"

#include <algorithm>
#include <cstring>

#include "base/check.h"
#include "runtime/device/commands.h"

namespace zc {
namespace {

constexpr std::uint64_t kAlign = 16;
constexpr VkPipelineStageFlags kAll = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
constexpr VkAccessFlags kAny = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;

void copy(VkCommandBuffer c, const Buffer& from, std::uint64_t from_bytes, const Buffer& to, std::uint64_t to_bytes,
          std::uint64_t bytes) {
  const VkBufferCopy region{from_bytes, to_bytes, bytes};
  vkCmdCopyBuffer(c, from.handle(), to.handle(), 1, &region);
  memory_barrier(c, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT,
                 VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT);
}

}  // namespace

Status Transfers::create(std::uint64_t ring_bytes, std::uint32_t frames_in_flight) {
  ZC_CHECK(frames_in_flight > 0 && ring_bytes >= 4 * kAlign);
  frames_in_flight_ = frames_in_flight;
  capacity_ = ring_bytes / 4 * 3 / kAlign * kAlign;  // the rest is what moves go through
  queued_.reserve(kQueuedMost);
  ZC_ASSIGN(ring_,
            Buffer::create(device_, ring_bytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                           MemoryUse::kUpload));
  return {};
}

bool Transfers::take(std::uint64_t bytes, std::uint64_t& offset) {
  const std::uint64_t rounded = (bytes + kAlign - 1) / kAlign * kAlign;
  std::uint64_t begin = head_;
  const std::uint64_t left = capacity_ - begin % capacity_;
  if (left < rounded) begin += left;  // in one piece
  if (begin + rounded - tail_ > capacity_) return false;
  offset = begin % capacity_;
  head_ = begin + rounded;
  return true;
}

Status Transfers::write(const Buffer& target, std::uint64_t offset, std::span<const std::byte> bytes) {
  ZC_CHECK(offset + bytes.size() <= target.bytes());
  while (!bytes.empty()) {
    const std::size_t part = std::min<std::size_t>(bytes.size(), capacity_ / 2 / kAlign * kAlign);
    std::uint64_t at = 0;
    if (!take(part, at)) {
      ++waits_;
      ZC_TRY(finish());
      ZC_CHECK(take(part, at));
    }
    std::memcpy(ring_.mapped().data() + at, bytes.data(), part);
    ZC_TRY(queue({&target, false, at, offset, part}));
    bytes = bytes.subspan(part);
    offset += part;
  }
  return {};
}

Status Transfers::move(const Buffer& target, std::uint64_t from, std::uint64_t to, std::uint64_t bytes) {
  ZC_CHECK(std::max(from, to) + bytes <= target.bytes());
  if (bytes == 0 || from == to) return {};
  return queue({&target, true, from, to, bytes});
}

Status Transfers::queue(const Operation& operation) {
  queued_.push_back(operation);
  if (queued_.size() < kQueuedMost) return {};
  ++waits_;
  return finish();
}

void Transfers::record(VkCommandBuffer commands) {
  frames_.push_back(head_);
  if (frames_.size() > frames_in_flight_) {
    tail_ = frames_.front();
    frames_.pop_front();
  }
  if (queued_.empty()) return;
  memory_barrier(commands, kAll, kAny, VK_PIPELINE_STAGE_TRANSFER_BIT,
                 VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT);
  const std::uint64_t through = ring_.bytes() - capacity_;
  for (const Operation& op : queued_) {
    if (!op.is_move) {
      copy(commands, ring_, op.from, *op.target, op.to, op.bytes);
      continue;
    }
    // Copies within one buffer must not overlap: part by part, from the side that is safe.
    for (std::uint64_t done = 0; done < op.bytes;) {
      const std::uint64_t part = std::min(op.bytes - done, through);
      const std::uint64_t at = op.to < op.from ? done : op.bytes - done - part;
      copy(commands, *op.target, op.from + at, ring_, capacity_, part);
      copy(commands, ring_, capacity_, *op.target, op.to + at, part);
      done += part;
    }
  }
  queued_.clear();
  memory_barrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT, kAll, kAny);
}

// The queue runs in order, so what was recorded before has been executed too.
Status Transfers::finish() {
  ZC_TRY(device_.run([&](VkCommandBuffer c) { record(c); }));
  frames_.clear();
  tail_ = head_;
  return {};
}

}  // namespace zc
