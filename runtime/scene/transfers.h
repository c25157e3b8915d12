// SPDX-License-Identifier: Apache-2.0
// Writes and moves that wait for a host to record them into its command buffer: bytes are copied into a ring of staging
// memory at once, so that the caller's may go. Frames in flight read what was recorded before them; the ring's part of
// a frame is used again when so many later ones were recorded. Owns: the ring. Borrows: device and targets. Threads: as
// the device. Units: bytes.
#pragma once

#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "runtime/device/resources.h"

namespace zc {

class Transfers {
 public:
  explicit Transfers(Device& device) : device_(device) {}
  // frames_in_flight: how many recorded frames may not have been executed when the next is recorded, at least 1.
  Status create(std::uint64_t ring_bytes, std::uint32_t frames_in_flight);

  // As memcpy and memmove, in the order of the calls. What does not fit into the ring or the queue is submitted and
  // waited for with all that was queued before, on the device's own queue; waits() counts that.
  Status write(const Buffer& target, std::uint64_t offset, std::span<const std::byte> bytes);
  Status move(const Buffer& target, std::uint64_t from, std::uint64_t to, std::uint64_t bytes);

  // All that is queued; a barrier makes it visible to what follows, and one before it waits for what reads the targets.
  void record(VkCommandBuffer commands);
  // The same on the device's own queue, and waits.
  Status finish();

  [[nodiscard]] std::uint64_t waits() const { return waits_; }

  // On the heap, from create() on.
  [[nodiscard]] static std::uint64_t heap_bytes() { return kQueuedMost * sizeof(Operation); }

 private:
  static constexpr std::size_t kQueuedMost = 256;
  struct Operation {
    const Buffer* target;
    bool is_move;
    std::uint64_t from, to, bytes;  // from: in the ring, or of a move in the target
  };
  Status queue(const Operation& operation);
  // Contiguous room, or none.
  bool take(std::uint64_t bytes, std::uint64_t& offset);

  Device& device_;
  Buffer ring_;
  std::uint64_t capacity_ = 0;        // of the ring, without what moves go through
  std::uint64_t head_ = 0;            // bytes ever taken
  std::uint64_t tail_ = 0;            // of those, free again
  std::deque<std::uint64_t> frames_;  // head_ after each recorded frame
  std::uint32_t frames_in_flight_ = 1;
  std::vector<Operation> queued_;
  std::uint64_t waits_ = 0;
};

}  // namespace zc
